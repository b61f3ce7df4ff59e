// SPDX-License-Identifier: Apache-2.0
#include "report/plot/heat_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "report/process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::report::heat_map_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

HeatMap example() {
  HeatMap map;
  map.title = "sigma [mm]";
  map.x_label = "pitch [px]";
  map.y_label = "bits <&>";
  map.x_names = {"8", "`touch /tmp/x`", "[13, 14]"};
  map.y_names = {"8", "12"};
  map.values = {{0.001, 0.02, std::nan("")}, {0.5, 0.25, 0.125}};
  map.limits = limits_of(map.values, map.scale);
  return map;
}

TEST(HeatMap, CellsWithTheirNumbersAndABar) {
  const auto gnuplot = run_process({"gnuplot", "--version"}, "");
  if (!gnuplot || gnuplot->status != 0) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  const std::string svg = drawing_svg(drawing(example()), "h-");
  for (const char* text :
       {"0.001", "0.02", "0.125", "sigma [mm]", "bits &lt;&amp;>", "[13, 14]", "'touch /tmp/x'"})
    EXPECT_THAT(svg, HasSubstr(text));
  EXPECT_THAT(svg, Not(HasSubstr("<image"))) << "cells are shapes, not a picture beside the page";
}

TEST(HeatMap, NumbersOnlyWhereTheCellsHaveRoom) {
  HeatMap map = example();
  EXPECT_THAT(drawing(map).script, HasSubstr("\"0.125\""));
  map.x_names.assign(60, "1");
  map.values.assign(2, std::vector<double>(60, 0.125));
  EXPECT_THAT(drawing(map).script, Not(HasSubstr("\"0.125\"")));
}

// Viridis is dark where values are small and bright where they are large.
TEST(HeatMap, LettersDifferFromTheirCells) {
  const std::string script = drawing(example()).script;
  const auto block = [&](const std::string& name) {
    const std::size_t first = script.find("$" + name + " << EOD\n");
    return first == std::string::npos ? "" : script.substr(first, script.find("\nEOD", first) - first);
  };
  EXPECT_THAT(block("light"), HasSubstr("\"0.00100\""));
  EXPECT_THAT(block("light"), Not(HasSubstr("\"0.5")));
  EXPECT_THAT(block("dark"), HasSubstr("\"0.5"));
  EXPECT_THAT(script, HasSubstr("$light with labels tc rgb \"#ffffff\""));
}

TEST(HeatMap, LimitsAroundZeroAndOfEqualValues) {
  const MapLimits around = limits_of({{-1.0, 3.0}}, Scale::diverging),
                  equal = limits_of({{2.0, 2.0}}, Scale::viridis);
  EXPECT_EQ(around.low, -3.0);
  EXPECT_EQ(around.high, 3.0);
  EXPECT_LT(equal.low, 2.0);
  EXPECT_GT(equal.high, 2.0);
}

TEST(HeatMap, NothingToDrawIsSaid) {
  HeatMap map = example();
  map.values.assign(2, std::vector<double>(3, std::nan("")));
  EXPECT_THROW(drawing_svg(drawing(map), "h-"), UserError);
}

}  // namespace
}  // namespace fringetwin::report::heat_map_test
