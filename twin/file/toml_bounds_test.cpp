// SPDX-License-Identifier: Apache-2.0
#include "twin/file/toml_bounds.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::toml_bounds_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

std::string repeated(const std::string& part, int n) {
  std::string text;
  for (int i = 0; i < n; ++i) text += part;
  return text;
}

class TomlBounds : public ::testing::Test {
 protected:
  void TearDown() override { raise_file_limits(1.0); }
  std::string refusal(const std::string& text) {
    const fs::path file = folder_.path() / "file.toml";
    std::ofstream(file, std::ios::binary) << text;
    try {
      TomlTable::parse_file(file, ExitCode::usage);
      return "";
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::usage);
      return e.what();
    }
  }
  ScratchFolder folder_;
};

// Each of these overflowed the stack.
TEST_F(TomlBounds, RefusesKeysOfManyParts) {
  const std::string parts = repeated("a.", 100'000) + "b";
  for (const std::string& text :
       {"\n" + parts + " = 1", "\n[" + parts + "]", "\n[[" + parts + "]]", "\nx = { " + parts + " = 1 }",
        "\n" + repeated("\"a\" . ", 100'000) + "b = 1"})
    EXPECT_THAT(refusal(text), HasSubstr("file.toml:2: a key has more than 32 parts"));
}

TEST_F(TomlBounds, RefusesValuesThatStandDeepInEachOther) {
  EXPECT_THAT(refusal("\n\nx = " + repeated("[", 100'000)),
              AllOf(HasSubstr("file.toml:3: "), HasSubstr("more than 32 deep"), HasSubstr("left open?")));
  EXPECT_THAT(refusal("x = " + repeated("{ a.b.c = ", 100) + "1" + repeated(" }", 100)),
              HasSubstr("more than 32 deep"));
}

TEST_F(TomlBounds, RefusesMoreValuesThanAnyFileHas) {
  const std::string many = "x = [" + repeated("0,", 1'000'000) + "]";
  EXPECT_THAT(refusal(many), AllOf(HasSubstr("more than 1000000 keys and values"), HasSubstr("--limits 10")));
  raise_file_limits(2.0);
  EXPECT_FALSE(toml_excess(many));
}

// The library looks for each in a list of all.
TEST_F(TomlBounds, RefusesMoreTablesThanAnyFileHas) {
  std::string keys, headers;
  for (int i = 0; i < 60'000; ++i) {
    keys += fmt::format("a{}.b = 1.5\n", i);
    headers += fmt::format("  [[a{}]]\n", i);
  }
  for (const std::string& text : {keys, headers, "x = {" + repeated("a.b.c = 1,", 30'000) + "}"})
    EXPECT_THAT(refusal(text),
                AllOf(HasSubstr("more than 50000 headers and dots"), HasSubstr("--limits 10")));
  EXPECT_FALSE(toml_excess("x = [" + repeated("\n[0.5, 1.5],", 100'000) + "]"));
  EXPECT_FALSE(toml_excess(repeated("x = 0.5\n", 100'000)));
}

TEST_F(TomlBounds, CountsNoTextAndNoComments) {
  const std::string dots(1000, '.'), brackets(1000, '[');
  for (const std::string& text :
       {"a = 1 # " + dots + brackets, "a = \"" + dots + "\\\"" + brackets + "\"", "a = '" + dots + "\\'",
        "a = \"\"\"" + dots + "\n\"\" " + brackets + "\\\"\"\"\"\"\"",
        "a = '''" + dots + "'' \\\n" + brackets + "'''''", "\"" + dots + "\" = 1",
        "a = [\n" + repeated("  [0.5, 1.5],\n", 1000) + "]", repeated("a.b = 1\n", 1),
        "a = \"\"\nb = ''\n# " + brackets})
    EXPECT_EQ(refusal(text), "") << text;
  EXPECT_EQ(refusal("x = " + repeated("[", 32) + repeated("]", 32)), "");
  EXPECT_EQ(refusal(repeated("a.", 31) + "b = 1"), "");
}

TEST_F(TomlBounds, WhatIsNoTomlIsLeftToTheLibrary) {
  for (const std::string text : {"a = \"unclosed\nb = 1", "a = '''", "]]]]", "a = \\", "\"", "= = ="})
    EXPECT_THAT(refusal(text), HasSubstr("is no valid TOML"));
}

TEST_F(TomlBounds, HoldForCaptureSetsAndSettings) {
  std::ofstream(folder_.path() / "capture.toml") << repeated("a.", 100'000) << "b = 1";
  EXPECT_THROW(read_capture_set(folder_.path(), 3), UserError);
  const fs::path file = folder_.path() / "twin.toml";
  std::ofstream(file) << "schema = \"fringetwin-twin/1\"\n";
  for (const auto& [key, value] : {std::pair{repeated("a.", 100'000) + "b", std::string("1")},
                                   {"a", repeated("[", 100'000)},
                                   {"a", "{ " + repeated("a.", 100'000) + "b = 1 }"}})
    EXPECT_THROW(load_twin(file, {{key, value}}), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::toml_bounds_test
