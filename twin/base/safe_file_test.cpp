// SPDX-License-Identifier: Apache-2.0
#include "twin/base/safe_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/twin/child_process.hpp"

namespace fringetwin::testing::safe_file_test {
namespace {

namespace fs = std::filesystem;

const FileUse kModel{.kind = FileKind::text, .what = "camera model", .hint = "check the path"};

std::string sentence_of(const fs::path& file) {
  try {
    check_readable(file, kModel);
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    return e.what();
  }
  return "";
}

class SafeFile : public ::testing::Test {
 protected:
  void TearDown() override { raise_file_limits(1.0); }
  ScratchFolder dir_;
};

TEST_F(SafeFile, ReturnsEveryByte) {
  const fs::path file = dir_.path() / "bytes";
  const std::string content("a\0b\r\n\xff", 6);
  std::ofstream(file, std::ios::binary) << content;
  EXPECT_EQ(read_whole_text(file, kModel), content);
  EXPECT_EQ(read_whole_bytes(file, kModel), std::vector<std::uint8_t>(content.begin(), content.end()));
  EXPECT_EQ(check_readable(file, kModel), 6u);
}

TEST_F(SafeFile, RefusesWhatIsNoRegularFileWithoutWaiting) {
  const fs::path pipe = dir_.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_NE(sentence_of(pipe).find("is a pipe or a device"), std::string::npos);
  EXPECT_NE(sentence_of("/dev/zero").find("is a pipe or a device"), std::string::npos);
  EXPECT_NE(sentence_of(dir_.path()).find("is a folder"), std::string::npos);
  EXPECT_NE(sentence_of(dir_.path() / "none").find("check the path"), std::string::npos);
}

TEST_F(SafeFile, RefusesWhatIsAboveTheLimitUntilItIsRaised) {
  const fs::path file = dir_.path() / "large";
  std::ofstream(file).close();
  fs::resize_file(file, 64 * 1024 * 1024 + 1);  // sparse: no byte is written
  EXPECT_NE(sentence_of(file).find("has 67108865 bytes, at most 67108864 are read"), std::string::npos);
  raise_file_limits(2.0);
  EXPECT_EQ(sentence_of(file), "");
}

}  // namespace
}  // namespace fringetwin::testing::safe_file_test
