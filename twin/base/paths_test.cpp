// SPDX-License-Identifier: Apache-2.0
// tolerance: none, paths and sentences are exact.
#include "twin/base/paths.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/out_folder.hpp"

namespace fringetwin::paths_test {
namespace {
namespace fs = std::filesystem;
using ::testing::HasSubstr;

class TidyPath : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("fringetwin_paths_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "far" / "away");
    fs::create_directories(folder_ / "near");
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

// near/link -> far/away, so near/link/.. is far, not near.
TEST_F(TidyPath, TheParentOfALinkIsTheParentOfItsTarget) {
  fs::create_directory_symlink(folder_ / "far" / "away", folder_ / "near" / "link");
  std::ofstream(folder_ / "far" / "part.ply") << "x";
  const fs::path tidy = tidy_path(folder_ / "near" / "link" / ".." / "part.ply");
  EXPECT_EQ(tidy, folder_ / "far" / "part.ply");
  EXPECT_TRUE(fs::exists(tidy));
}

TEST_F(TidyPath, WithoutDotDotLinksStayAsWritten) {
  fs::create_directory_symlink(folder_ / "far" / "away", folder_ / "near" / "link");
  EXPECT_EQ(tidy_path(folder_ / "near" / "." / "link" / "x.png"), folder_ / "near" / "link" / "x.png");
  EXPECT_EQ(tidy_path("a.png"), fs::current_path() / "a.png");
}

TEST_F(TidyPath, WhatDoesNotExistMayBeNamed) {
  EXPECT_EQ(tidy_path(folder_ / "none" / ".." / "part.ply"), folder_ / "part.ply");
}

TEST_F(TidyPath, ALoopOfLinksIsLeftToTheOneWhoOpensIt) {
  fs::create_symlink(folder_ / "b", folder_ / "a");
  fs::create_symlink(folder_ / "a", folder_ / "b");
  EXPECT_NO_THROW(tidy_path(folder_ / "a" / ".." / "x"));
}

TEST(Names, WhatMayBecomePartOfAFileName) {
  for (const char* name : {"left", "Camera 2", "a-b_c.d", "7", "x."}) EXPECT_EQ(name_fault(name), "") << name;
  for (const char* name : {"a/b", "../x", "a\\b", ".hidden", ".", "..", "50%", "say \"hi\"", " left", "left ",
                           "a\tb", "a\nb", "caf\xc3\xa9", "a:b", "a*"})
    EXPECT_THAT(name_fault(name), HasSubstr("cannot become part of a file name")) << name;
  EXPECT_EQ(name_fault(""), "must not be empty");
  EXPECT_EQ(name_fault(std::string(100, 'a')), "");
  EXPECT_THAT(name_fault(std::string(101, 'a')), HasSubstr("at most 100"));
}

TEST(OutFolder, IsOfOneProcessAtATime) {
  const fringetwin::testing::ScratchFolder scratch;
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

/// Returns whether another process could take the folder now.
bool is_free(const std::filesystem::path& folder) {
  const int other = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool taken = ::flock(other, LOCK_EX | LOCK_NB) == 0;
  ::close(other);
  return taken;
}

TEST(OutFolder, IsGivenBackAtTheEndOfACall) {
  const fringetwin::testing::ScratchFolder of_process, of_call;
  begin_output(of_process.path(), {});
  {
    const FoldersOfCall call;
    {
      const FoldersOfCall inner;
      begin_output(of_call.path(), {});
    }
    begin_output(of_call.path(), {});
    begin_output(of_process.path(), {});
    EXPECT_FALSE(is_free(of_call.path()));
    std::thread([&] {
      EXPECT_FALSE(hold_folder(of_call.path())) << "another call of the same process waits, too";
      const FoldersOfCall other;
      EXPECT_FALSE(hold_folder(of_call.path()));
      EXPECT_TRUE(hold_folder(of_process.path()));
    }).join();
    EXPECT_FALSE(is_free(of_call.path())) << "the other call gave back what was not its own";
  }
  EXPECT_TRUE(is_free(of_call.path()));
  EXPECT_FALSE(is_free(of_process.path())) << "what a process takes outside a call it keeps";
}

}  // namespace
}  // namespace fringetwin::paths_test
