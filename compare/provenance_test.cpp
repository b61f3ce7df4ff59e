// SPDX-License-Identifier: Apache-2.0
// Truth: FIPS 180-4 test vectors.
#include "compare/provenance.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "twin/errors.hpp"

namespace fringetwin::compare::provenance_test {
namespace {

std::filesystem::path write(const std::string& name, const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() / ("fringetwin_provenance_" + name);
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

TEST(Provenance, Sha256MatchesTheStandard) {
  EXPECT_EQ(sha256_of_file(write("abc", "abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of_file(write("empty", "")),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of_file(write("a", std::string(1'000'000, 'a'))),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Provenance, EachFileOnce) {
  const auto file = write("abc", "abc");
  EXPECT_EQ(sha256_of_files({file, file}).size(), 1u);
}

TEST(Provenance, AMissingFileIsNamed) {
  try {
    sha256_of_file("/nowhere/image.png");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::input);
    EXPECT_NE(std::string(error.what()).find("/nowhere/image.png"), std::string::npos);
  }
}

}  // namespace
}  // namespace fringetwin::compare::provenance_test
