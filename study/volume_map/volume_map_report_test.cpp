// SPDX-License-Identifier: Apache-2.0
// The page of a volume map made of outcomes by hand.
// tolerance: none, numbers as they are printed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "study/study_file.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study::volume_map_report_test {
namespace {

using ::testing::HasSubstr, ::testing::Not;

TEST(VolumeMapReport, WhenAnIntervalIsTheRangeOfTheTrials) {
  const auto page = [](std::size_t trials, double coverage) {
    VolumeMapPlan plan;
    plan.trials = trials;
    plan.coverage = coverage;
    VolumeMap map;
    map.positions.resize(1);
    map.measured = 1;
    return volume_map_report({{}, {}, {}, {"fringetwin"}, "1"}, plan, map).html;
  };
  const auto range = HasSubstr("an interval is the range of all of them");
  for (const std::size_t trials : {5, 20, 30}) EXPECT_THAT(page(trials, 0.95), range) << trials;
  EXPECT_THAT(page(31, 0.95), Not(range));
  EXPECT_THAT(page(20, 0.9), Not(range));
  EXPECT_THAT(page(20, 0.95), HasSubstr("±0.47 sigma only"));  // Student, 19 degrees of freedom: 2.093/√20
}

TEST(VolumeMapReport, SlicesSpacingAndTheWorst) {
  VolumeMapPlan plan;
  plan.object = "ball";
  plan.radius_mm = 10.0;
  plan.counts = {3, 2, 2};
  plan.trials = 5;
  VolumeMap map;
  for (int i = 0; i < 12; ++i) {
    MapPosition p;
    p.center_mm = {10.0 * (i % 3), 20.0 * (i / 3 % 2), 300.0 + 50.0 * (i / 6)};
    p.n = 5;
    const double v = 0.001 * (i + 1);
    for (const char* name : {"x_mm", "y_mm", "z_mm", "size_mm", "form_mm"})
      p.numbers[name] = {v, 0.1 * v, {0.5 * v, 1.5 * v}};
    map.positions.push_back(p);
  }
  map.measured = 11;
  map.spacings = {{0, 11, 55.0, {0.011, 0.002, {0.01, 0.012}, 5}}};
  for (const char* name : {"x_mm", "y_mm", "z_mm", "size_mm", "form_mm"}) map.worst[name] = {11, 11};
  map.worst_spacing = MapWorst{0, 0};
  map.largest_mm = {0.013, 0.003, {0.01, 0.014}, 4};
  StudyHead head;
  head.name = "map <m>";
  const StudyReport report = volume_map_report({head, {}, {}, {"fringetwin"}, "1"}, plan, map);
  EXPECT_THAT(report.html, HasSubstr("map &lt;m&gt;"));
  EXPECT_THAT(report.html, HasSubstr("11 of 12 positions were measured in every trial"));
  EXPECT_THAT(report.html, HasSubstr("0.0120 (0.00600 … 0.0180)"));  // the worst, with its interval
  EXPECT_THAT(report.html, HasSubstr("(0, 0, 300) to (20, 20, 350)"));
  EXPECT_THAT(report.html, HasSubstr("(4 of 5 trials have all pairs)"));
  EXPECT_THAT(report.html, HasSubstr("pairs that were measured in every trial"));
  EXPECT_THAT(report.html, HasSubstr("between 0.60 and 2.87 times"));  // chi-square, 4 degrees of freedom
  EXPECT_THAT(report.html, Not(HasSubstr("map-form_95_mm")));          // nothing of it was measured
  // spacing twice; mean and sigma of five numbers in two slices
  ASSERT_EQ(report.figures.size(), 2u + 20u);
  EXPECT_EQ(report.figures[2].first, "x_mm-z-300-mm-mean");
  // y points down: the upper row of the first slice is y = 0 (x_mm 0.001 ...), at gnuplot's y = 1
  const std::string& svg = report.figures[2].second;
  EXPECT_LT(svg.find(">0.00400<"), svg.find(">0.00100<")) << "rows are written from the bottom";
}

}  // namespace
}  // namespace fringetwin::study::volume_map_report_test
