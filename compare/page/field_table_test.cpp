// SPDX-License-Identifier: Apache-2.0
// A plain table of the page has the columns that the fields name, in their order, with their digits.
#include "compare/page/field_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/text.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare::field_table_test {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> headers(const report::Table& table) {
  std::vector<std::string> out;
  for (const report::Column& column : table.columns) out.push_back(column.header);
  return out;
}

/// A row with every style of column, and a number without one.
struct Reading {
  std::string camera;
  double mean_rad = 0.0, rms_rad = 0.0, share = 0.0, gain_dn = 0.0, gain_sigma_dn = 0.0, hidden = 0.0;
  std::uint64_t n = 0;

  static void describe(auto& f) {
    f.name("camera", "camera of the twin", &Reading::camera).shown({"camera"});
    f.add("n", "values used", &Reading::n).shown({.header = "n", .place = 1});
    f.add("mean_rad", "mean of the values", &Reading::mean_rad)
        .shown({"mean", "rad", Column::signed_fixed, 5});
    f.positive("rms_rad", "rms of the values", &Reading::rms_rad).shown({"rms", "rad", Column::fixed, 5});
    f.add("hidden", "not on the page", &Reading::hidden);
    f.positive("share", "share of them", &Reading::share)
        .shown({"share", "%", Column::significant, 3, 100.0});
    f.add("gain_dn", "gain of the camera", &Reading::gain_dn).shown({"gain", "DN", Column::with_sigma});
    f.sigma("gain_sigma_dn", "standard error of the gain", &Reading::gain_sigma_dn);
  }
};

TEST(FieldTable, ShowsTheFieldsThatHaveAColumn) {
  const Reading row{"left", -0.0123456, 0.25, 0.00123, 17.3021, 0.0042, 5.0, 1234};
  const report::Table table = field_table(std::vector<Reading>{row});
  EXPECT_THAT(headers(table), ElementsAre("camera", "mean", "rms", "share", "gain", "n"));
  EXPECT_EQ(table.columns[0].align, report::Align::left);
  EXPECT_EQ(table.columns[1].align, report::Align::right);
  EXPECT_EQ(table.columns[3].unit, "%");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_THAT(table.rows[0].cells,
              ElementsAre("left", "−0.01235", "0.25000", "0.123", "17.3021 ± 0.0042", report::count(1234)));
}

/// A number that is printed with another standard error than its own.
struct WideReading {
  double gain_dn = 17.3, gain_sigma_dn = 0.01, gain_total_sigma_dn = 0.25;

  static void describe(auto& f) {
    f.add("gain_dn", "gain of the camera", &WideReading::gain_dn)
        .shown({.header = "gain", .style = Column::with_sigma, .sigma = "gain_total_sigma_dn"});
    f.sigma("gain_sigma_dn", "standard error of the gain", &WideReading::gain_sigma_dn);
    f.positive("gain_total_sigma_dn", "the same, widened", &WideReading::gain_total_sigma_dn).error();
  }
};

TEST(FieldTable, TheColumnMayNameAnotherStandardError) {
  EXPECT_EQ(field_table(std::vector<WideReading>{{}}).rows.at(0).cells.at(0), "17.30 ± 0.25");
  EXPECT_EQ(find_field(fields<WideReading>(), "gain_dn")->sigma, "gain_sigma_dn");
}

TEST(FieldTable, AnUnknownNumberIsADash) {
  Reading row;
  row.gain_dn = kNaN;
  EXPECT_EQ(field_table(std::vector<Reading>{row}).rows[0].cells[4], "–");
}

}  // namespace
}  // namespace fringetwin::compare::field_table_test
