// SPDX-License-Identifier: Apache-2.0
// A plain table of the page has the columns that the fields name, in their order, with their digits.
#include "compare/page/field_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compare/result/rows.hpp"
#include "report/text.hpp"

namespace fringetwin::compare::field_table_test {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> headers(const report::Table& table) {
  std::vector<std::string> out;
  for (const report::Column& column : table.columns) out.push_back(column.header);
  return out;
}

TEST(FieldTable, ShowsTheFieldsThatHaveAColumn) {
  PhaseRow row{"left", "x", -0.0123456, 0.25, 0.5, 0.00123, 1234, 7};
  const report::Table table = field_table(std::vector<PhaseRow>{row});
  EXPECT_THAT(headers(table), ElementsAre("camera", "direction", "mean", "rms", "P99 of |d|",
                                          "mean |ΔΦ| / mean |Φ|", "n", "order disagrees"));
  EXPECT_EQ(table.columns[0].align, report::Align::left);
  EXPECT_EQ(table.columns[2].align, report::Align::right);
  EXPECT_EQ(table.columns[5].unit, "%");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_THAT(table.rows[0].cells,
              ElementsAre("left", "x", "−0.01235", "0.25000", "0.50000", "0.123", report::count(1234), "7"));
}

TEST(FieldTable, AColumnMayStandFurtherRightAndAValueMayCarryItsError) {
  GainRow row;
  row.camera = "left";
  row.gain_dn = 17.3021;
  row.gain_sigma_dn = 0.0042;
  row.black_level_dn = kNaN;
  const report::Table table = field_table(std::vector<GainRow>{row});
  EXPECT_THAT(headers(table), ElementsAre("camera", "gain", "black level", "rms before", "rms after", "R²",
                                          "beyond Huber", "σ inflation", "n"));
  EXPECT_EQ(table.rows[0].cells[1], "17.3021 ± 0.0042");
  EXPECT_EQ(table.rows[0].cells[2], "–");
}

}  // namespace
}  // namespace fringetwin::compare::field_table_test
