// SPDX-License-Identifier: Apache-2.0
#include "report/json_file.hpp"

#include <gtest/gtest.h>

#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/expect_user_error.hpp"

namespace fringetwin::testing::json_file_test {
namespace {

class JsonFile : public ::testing::Test {
 protected:
  void TearDown() override { raise_file_limits(1.0); }
  nlohmann::json read(const std::string& text) {
    return report::read_json_file(folder_.write("file.json", text), {.what = "result"});
  }
  void expect_refused(const std::string& text, const std::string& words) {
    expect_user_error(ExitCode::input, "file.json: " + words, [&] { read(text); });
  }
  ScratchFolder folder_;
};

TEST_F(JsonFile, ReadsWhatIsThere) {
  EXPECT_EQ(read(R"({"b": [1, 2.5], "a": "[[{\"\\"})").dump(), R"({"a":"[[{\"\\","b":[1,2.5]})");
  EXPECT_TRUE(read(std::string(64, '[') + std::string(64, ']')).is_array());
}

TEST_F(JsonFile, RefusesWhatIsNoJson) {
  for (const char* text : {"", "{", "[1,]", "\"", "\"\\", "{\"a\": 1e999}", "[-1e999]", "nan", "[1] 2"})
    expect_refused(text, "this is no JSON");
}

TEST_F(JsonFile, RefusesWhatIsTooDeepOrTooFull) {
  expect_refused(std::string(100'000, '['), "lists or tables stand more than 64 deep");
  const std::string many = "[" + std::string(1'000'001, ',') + "]";
  expect_refused(many, "has more than 1000000 values");
  raise_file_limits(2.0);
  expect_refused(many, "this is no JSON");
}

}  // namespace
}  // namespace fringetwin::testing::json_file_test
