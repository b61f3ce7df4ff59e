// SPDX-License-Identifier: Apache-2.0
// The page of a search made of evaluations by hand.
// tolerance: none, numbers as they are printed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "study/optimise/optimise.hpp"
#include "study/study_file.hpp"

namespace fringetwin::study::optimise_report_test {
namespace {

using ::testing::HasSubstr, ::testing::Not;

OptimisePlan plan() {
  OptimisePlan out;
  Variation blur{{"projector.blur_px"}, {}, {}, Range{0.0, 2.0, std::nullopt, false}};
  Variation steps{{"fringes.steps"}, {"3", "4"}, {}, std::nullopt};
  out.choose = {blur, steps};
  out.result = "fits.ball.measured.radius_mm";
  out.constraints = {{"images.left.saturated", std::nullopt, 0.01}};
  return out;
}

Evaluation evaluation(double objective, double time_s, bool feasible, const std::string& blur) {
  Evaluation out;
  out.phase = "global";
  out.values = {{"projector.blur_px", blur}, {"fringes.steps", time_s > 1.0 ? "4" : "3"}};
  out.objective = {objective, 0.1 * objective, {0.8 * objective, 1.3 * objective}, 50};
  out.constraints = {{feasible ? 0.0 : 0.5, 0.001, {}, 50}};
  out.time_s = time_s;
  out.feasible = feasible;
  return out;
}

TEST(OptimiseReport, BestFrontAndWhatIsNotFeasible) {
  OptimiseResult result;
  result.evaluations = {evaluation(0.004, 1.0, true, "0.5"), evaluation(0.001, 1.0, false, "1"),
                        evaluation(0.002, 2.0, true, "1.5")};
  result.best = 2;
  result.candidates = {{2, evaluation(0.0025, 2.0, true, "1.5")}, {0, evaluation(0.003, 1.0, true, "0.5")}};
  result.chosen = evaluation(0.0022, 2.0, true, "1.5");
  result.recommended = 0;
  result.front = {0};
  result.left_out = 3;
  result.left_out_reason = "steps: 2 are too few";
  StudyHead head;
  head.name = "opt <o>";
  const StudyReport report = optimise_report({head, {}, {}, {"fringetwin"}, "1"}, plan(), result);
  EXPECT_THAT(report.html, HasSubstr("opt &lt;o&gt;"));
  EXPECT_THAT(report.html, HasSubstr("2 of 3 evaluations meet all constraints, 0 failed"));
  EXPECT_THAT(report.html, HasSubstr("<td class=\"l\">projector.blur_px</td><td class=\"r\">1.5</td>"));
  EXPECT_THAT(report.html, HasSubstr("≤ 0.01"));
  EXPECT_THAT(report.html, HasSubstr("<td class=\"l\">3</td><td class=\"r\">0.002000 ± 0.00020</td>"));
  EXPECT_THAT(report.html, HasSubstr("0.00220 (95 % interval 0.00176 … 0.00286, 50 trials"));
  EXPECT_THAT(report.html, HasSubstr("0.00220 (0.00176 … 0.00286)")) << "not the 0.0025 that was the least";
  EXPECT_THAT(report.html, HasSubstr("not told apart, recommended"));
  EXPECT_THAT(report.html,
              HasSubstr("<td class=\"l\">A</td><td class=\"r\">0.00300 (0.00240 … 0.00390)</td>"));
  EXPECT_THAT(report.html, HasSubstr("3 settings are no valid twin and were left out: steps: 2 are too few"));
  EXPECT_THAT(report.html, Not(HasSubstr("0.001000 ± 0.00010"))) << "not among the best";
  ASSERT_EQ(report.figures.size(), 4u);  // progress, front, two parameters
  EXPECT_EQ(report.figures[0].first, "progress");
  EXPECT_EQ(report.figures[2].first, "objective-blur_px");
}

TEST(OptimiseReport, NothingFeasibleIsSaid) {
  OptimiseResult result;
  result.evaluations = {evaluation(0.001, std::nan(""), false, "1")};
  result.evaluations[0].failed = 1;
  StudyHead head;
  const StudyReport report = optimise_report({head, {}, {}, {"fringetwin"}, "1"}, plan(), result);
  EXPECT_THAT(report.html, HasSubstr("nothing that was tried meets all constraints"));
  EXPECT_THAT(report.html, HasSubstr("not feasible"));
  EXPECT_THAT(report.html, HasSubstr("0 of 1 evaluations meet all constraints, 1 failed"));
}

}  // namespace
}  // namespace fringetwin::study::optimise_report_test
