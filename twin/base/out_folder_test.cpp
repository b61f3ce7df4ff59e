// SPDX-License-Identifier: Apache-2.0
// tolerance: none, a folder is held or it is not.
#include "twin/base/out_folder.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include "tests/support/twin/child_process.hpp"

namespace fringetwin::out_folder_test {
namespace {

TEST(OutFolder, IsOfOneProcessAtATime) {
  const testing::ScratchFolder scratch;
  // A lock of its own open file is to us as another process's.
  const int other = ::open(scratch.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(other, LOCK_EX | LOCK_NB), 0);
  EXPECT_FALSE(hold_folder(scratch.path()));
  begin_output(scratch.path(), {}, Writers::several);
  ::close(other);
  EXPECT_TRUE(hold_folder(scratch.path()));
  EXPECT_TRUE(hold_folder(scratch.path())) << "it is ours";
  begin_output(scratch.path(), {});
  EXPECT_TRUE(hold_folder(scratch / "nowhere")) << "what cannot be locked belongs to everybody";
}

}  // namespace
}  // namespace fringetwin::out_folder_test
