// SPDX-License-Identifier: Apache-2.0
// The numbers on the page: each under its heading, of its side, in its unit. No tolerances: printed digits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "compare/page/report_parts.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::report_values_test {
namespace {

using ::testing::HasSubstr;

/// A page's input, and what it points to.
struct Page {
  Page() { std::filesystem::create_directories(dir); }
  ReportInput input() const {
    return {dir, sides.twin, sides.real, sides.simulated, comparison, options, "run"};
  }
  std::filesystem::path dir = std::filesystem::temp_directory_path() / "fringetwin_report_values";
  testing::SyntheticSides sides = testing::make_sides({});
  Comparison comparison;
  CompareOptions options;
};

/// Returns the text of the page with a bar between its elements: "left|dx|0.12".
std::string text_of(const std::string& html) {
  std::string text;
  bool inside = false;  // of a tag
  for (const char c : html) {
    if (c == '<') {
      inside = true;
      if (text.empty() || text.back() != '|') text += '|';
    } else if (c == '>') {
      inside = false;
    } else if (!inside && c != '\n') {
      text += c;
    }
  }
  return text;
}

TEST(ReportValues, ShiftTableHasEachNumberUnderItsHeading) {
  Page page;
  ShiftRow row;
  row.camera = "left";
  row.dx = {.mean_px = 0.125, .mean_sigma_px = 0.015, .rms_px = 0.25, .largest_px = 0.5, .n_blocks = 4};
  row.dx_px = row.dy_px = ImageF(6, 5, 0.125F);
  row.chi2_before = 9.0, row.chi2_after = 3.0;
  page.comparison.shift = {row};
  const std::string text = text_of(shift_html(page.input()));
  EXPECT_THAT(text,
              HasSubstr("|camera|component|mean|px|rms|px|largest|px|blocks|χ² before|per dof|χ² after|"));
  EXPECT_THAT(text, HasSubstr("|left|dx|0.125 ± 0.015|0.2500|0.5000|4|9.00|3.00|"));
  EXPECT_THAT(text, HasSubstr("|left|dy|–|")) << "of what no block tells nothing is said";
}

// A deviation of 2.5 um on every point makes a scale of 2.5 um.
TEST(ReportValues, DeviationsAreInMicrometres) {
  Page page;
  measure::ObjectFit& fit = page.sides.real.measurement->fits.at(0);
  for (std::size_t i = 0; i < fit.deviation_mm.size(); ++i)
    fit.deviation_mm[i] = i % 2 == 0 ? 2.5e-3F : -2.5e-3F;
  page.sides.simulated.measurement.reset();
  page.comparison.fits.resize(1);
  page.comparison.fits[0].object = "ball";
  const std::string text = text_of(geometry_figures_html(page.input()));
  EXPECT_THAT(text, HasSubstr("deviation [µm]"));
  EXPECT_THAT(text, HasSubstr("|−2.50|−1.25|0.00|+1.25|+2.50|"));
}

TEST(ReportValues, CoverageMapTellsTheSidesApart) {
  using enum PixelState;
  Image<PixelState> real(4, 1, dark), simulated = real;
  real(0, 0) = real(2, 0) = measured;
  simulated(1, 0) = simulated(2, 0) = measured;
  const ImageF map = coverage_map(real, simulated);
  EXPECT_EQ(map(0, 0), -1.0F) << "real only";
  EXPECT_EQ(map(1, 0), 1.0F) << "simulated only";
  EXPECT_EQ(map(2, 0), 0.0F);
  EXPECT_TRUE(std::isnan(map(3, 0)));
}

// The profiles run through the row of the first fitted object's centre: x/z f + cx = 70, y/z f + cy = 100.
TEST(ReportValues, ProfilesGoThroughTheObject) {
  Page page;
  const double z_mm = 250.0, per_px = z_mm / 384.0;
  std::get<SphereShape>(page.sides.twin.objects.at(0).shape).center_mm = {(70 - 96) * per_px,
                                                                          (100 - 80) * per_px, z_mm};
  EXPECT_EQ(shown_part(page.input(), 0).row, 100);
}

}  // namespace
}  // namespace fringetwin::compare::report_values_test
