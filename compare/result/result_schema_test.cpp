// SPDX-License-Identifier: Apache-2.0
// docs/result.schema.json is what the fields of the tables make.
#include "compare/result/result_schema.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "report/json.hpp"

namespace fringetwin::compare::result_schema_test {
namespace {

TEST(ResultSchema, TheCommittedFileIsWhatTheFieldsMake) {
  const char* root = std::getenv("FRINGETWIN_SOURCE");
  const auto committed = std::filesystem::path(root ? root : ".") / "docs/result.schema.json";
  std::ifstream in(committed);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto made = std::filesystem::temp_directory_path() / "fringetwin_result.schema.json";
  std::ofstream(made) << result_schema();
  EXPECT_TRUE(text == result_schema())
      << "the fields have changed: cp " << made.string() << " " << committed.string();
}

TEST(ResultSchema, SaysWhatAFieldIs) {
  const report::Json properties = report::Json::parse(result_schema())["properties"];
  const report::Json& gain = properties["gain"]["items"];
  EXPECT_EQ(gain["properties"]["gain_sigma_dn"]["$ref"], "#/$defs/positive");
  EXPECT_EQ(gain["properties"]["n"]["$ref"], "#/$defs/count");
  EXPECT_EQ(gain["additionalProperties"], false);
  const report::Json& required = gain["required"];
  EXPECT_NE(std::find(required.begin(), required.end(), "r2"), required.end());
  EXPECT_EQ(std::find(required.begin(), required.end(), "sigma_inflation"), required.end());
  EXPECT_EQ(properties["phase"]["items"]["properties"]["direction"]["enum"].size(), 2u);
  EXPECT_TRUE(properties["budget_verdict"]["properties"]["gray"]["enum"].back().is_null());
  EXPECT_EQ(properties["indicators"]["items"]["properties"]["objects"]["maxItems"], 2);
}

}  // namespace
}  // namespace fringetwin::compare::result_schema_test
