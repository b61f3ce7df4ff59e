// SPDX-License-Identifier: Apache-2.0
#include "compare/result/provenance.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "twin/base/errors.hpp"

namespace fringetwin::compare::provenance_test {
namespace {

std::filesystem::path write(const std::string& name, const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() / ("fringetwin_provenance_" + name);
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

TEST(Provenance, EachFileOnce) {
  const auto file = write("abc", "abc");
  EXPECT_EQ(sha256_of_files({file, file}).size(), 1u);
}

TEST(Provenance, AMissingFileIsNamed) {
  try {
    sha256_of_files({"/nowhere/image.png"});
    FAIL();
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::input);
    EXPECT_NE(std::string(error.what()).find("/nowhere/image.png"), std::string::npos);
  }
}

}  // namespace
}  // namespace fringetwin::compare::provenance_test
