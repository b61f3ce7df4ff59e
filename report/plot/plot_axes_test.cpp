// SPDX-License-Identifier: Apache-2.0
// What gnuplot writes at the axes: labels that differ, in a unit that fits. No tolerances: texts are exact.
#include "report/plot/plot_axes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <set>

#include "report/plot/plot.hpp"
#include "report/process.hpp"

namespace fringetwin::report::plot_axes_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Plot line(double low, double high) {
  Plot plot;
  plot.series = {{.x = {0.0, 1.0, 2.0}, .y = {low, 0.5 * (low + high), high}}};
  return plot;
}

/// Returns the texts of the drawing.
std::vector<std::string> texts(const Plot& plot) {
  const std::string svg = plot_svg(plot, "t-");
  const std::regex text("<text>(?:<tspan[^>]*>)?([^<]*)<");
  std::vector<std::string> out;
  for (std::sregex_iterator at(svg.begin(), svg.end(), text), end; at != end; ++at) out.push_back((*at)[1]);
  return out;
}

TEST(PlotAxes, NoTwoNumbersAtAnAxisLookAlike) {
  if (!run_process({"gnuplot", "--version"}, "")) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  for (const auto& [low, high] : {std::pair{2.5e-5, 3.5e-5},
                                  {1.99999, 2.00001},
                                  {-3e-9, 4e-9},
                                  {19.003121, 19.003127},
                                  {0.0, 1e-6},
                                  {1e6, 1e6 + 1e-4},
                                  {0.1, 0.9},
                                  {-250.0, 1000.0},
                                  {1e-30, 2e-30}}) {
    Plot plot = line(low, high);
    plot.x_tics = {{0.0, "begin"}, {2.0, "end"}};
    const std::vector<std::string> all = texts(plot);
    EXPECT_GE(all.size(), 6u);
    const std::set<std::string> different(all.begin(), all.end());
    EXPECT_EQ(different.size(), all.size())
        << low << " ... " << high << ": " << ::testing::PrintToString(all);
  }
}

TEST(PlotAxes, SmallLengthsAreInMicrometres) {
  Plot plot = line(2.5e-5, 3.5e-5);
  plot.y_label = "mean [mm]";
  plot.x_label = "distance [mm]";
  plot.y_range = {0.0, 4e-5};
  plot.series[0].y_low = {1e-5, 1e-5, 1e-5};
  const Plot shown = with_fitting_units(plot);
  EXPECT_EQ(shown.y_label, "mean [µm]");
  EXPECT_EQ(shown.x_label, "distance [mm]");  // 0 ... 2
  EXPECT_NEAR(shown.series[0].y[2], 0.035, 1e-15);
  EXPECT_NEAR(shown.series[0].y_low[0], 0.01, 1e-15);
  EXPECT_NEAR(shown.y_range->second, 0.04, 1e-15);
  EXPECT_EQ(shown.series[0].x, plot.series[0].x);
  EXPECT_THAT(gnuplot_script(plot), HasSubstr("set ylabel \"mean [µm]\""));
  for (const char* label : {"mean [rad]", "rms_mm", ""}) {
    plot.y_label = label;
    EXPECT_EQ(with_fitting_units(plot).series[0].y, plot.series[0].y) << label;
  }
  plot.y_label = "mean [mm]";
  plot.log_y = true;
  EXPECT_EQ(with_fitting_units(plot).y_label, "mean [mm]");
  plot.log_y = false;
  plot.y_range = {0.0, 0.02};
  EXPECT_EQ(with_fitting_units(plot).y_label, "mean [mm]");
  plot.series.clear();
  plot.y_range.reset();
  EXPECT_EQ(with_fitting_units(plot).y_label, "mean [mm]");  // no values, no unit that fits
}

TEST(PlotAxes, TheFormatIsGnuplotsOwnWhereThatWillDo) {
  EXPECT_EQ(tic_format(0.0, 1.0), "");
  EXPECT_EQ(tic_format(0.0, 3e-4), "");
  EXPECT_EQ(tic_format(2.5e-5, 3.5e-5), "%.3g");
  EXPECT_EQ(tic_format(1.0, 1.0), "");
  EXPECT_EQ(tic_format(std::nan(""), 1.0), "");
  EXPECT_EQ(digits_that_tell(1000.001, 1000.009), 8);
  EXPECT_EQ(digits_that_tell(0.0, 1.0), 3);
  EXPECT_EQ(digits_that_tell(1.0, 1.0), 3);
}

}  // namespace
}  // namespace fringetwin::report::plot_axes_test
