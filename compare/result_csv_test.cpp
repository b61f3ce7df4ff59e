// SPDX-License-Identifier: Apache-2.0
#include "compare/result_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fringetwin::compare::result_csv_test {
namespace {

using nlohmann::ordered_json;

TEST(ResultCsv, ATableForEachListOfRows) {
  const ordered_json result = ordered_json::parse(R"json({
    "schema": "fringetwin-result/1", "timing_s": {"load": 0.5}, "limits": [],
    "fits": [{"object": "ball, \"small\"", "real": {"center_mm": [1, 2.5, -3], "why": null}, "z": 0.1},
             {"object": "wall", "exact": true}],
    "explained": [{"quantity": "gray", "budget": [{"name": "noise", "variance": 1e-8},
                                                  {"name": "=sum", "variance": null}]}],
    "causes": {"named": "pose",
               "tested": [{"group": "pose", "parameters": [{"name": "ball.x", "sigma": 2}]}]}
  })json");
  const std::vector<CsvTable> tables = result_tables(result);
  std::vector<std::string> names;
  for (const CsvTable& table : tables) names.push_back(table.name);
  EXPECT_THAT(names, ::testing::ElementsAre("fits", "explained", "explained_budget", "causes_tested",
                                            "causes_tested_parameters"));
  EXPECT_EQ(tables[0].text,
            "object,real.center_mm.0,real.center_mm.1,real.center_mm.2,real.why,z,exact\r\n"
            "\"ball, \"\"small\"\"\",1,2.5,-3,,0.1,\r\n"
            "wall,,,,,,true\r\n");
  EXPECT_EQ(tables[1].text, "quantity\r\ngray\r\n");
  EXPECT_EQ(tables[2].text, "quantity,name,variance\r\ngray,noise,1e-08\r\ngray,'=sum,\r\n");
  EXPECT_EQ(tables[4].text, "group,name,sigma\r\npose,ball.x,2\r\n");
}

}  // namespace
}  // namespace fringetwin::compare::result_csv_test
