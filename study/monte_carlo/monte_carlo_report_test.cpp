// SPDX-License-Identifier: Apache-2.0
// The page of a Monte Carlo study made of trials by hand.
// tolerance: none, numbers as they are printed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/plan/random_draws.hpp"
#include "study/study_file.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::study::monte_carlo_report_test {
namespace {

using ::testing::HasSubstr, ::testing::Not;
using testing::write_file, testing::small_twin;

TEST(MonteCarloReport, NumbersIntervalsConvergenceAndRanking) {
  const auto dir = testing::scratch_folder("monte_carlo_report");
  write_file(dir / "twin.toml", small_twin());
  write_file(dir / "STUDY.toml", R"(schema = "fringetwin-study/1"
name = "mc"
kind = "monte-carlo"
twin = "twin.toml"
block_trials = 50
least_blocks = 4
digits = 1
most_trials = 400
sensitivity_rows = 100
[[uncertain]]
key = "object.ball.radius_mm"
name = "size <s>"
sigma = 0.01
[[uncertain]]
key = "camera.left.sensor.gain_dn"
name = "gain"
half_width = 2
[[record]]
result = "fits.ball.measured.radius_mm"
name = "radius_mm"
)");
  const StudyFile file = load_study(dir / "STUDY.toml");
  const MonteCarloPlan plan = std::get<MonteCarloPlan>(file.plan);
  std::vector<StoredPoint> rows;
  const MonteCarloResult result = run_monte_carlo(plan, [&](const std::vector<StudyPoint>& points) {
    std::vector<PointOutcome> out;
    for (const StudyPoint& p : points) {
      PointOutcome o{p.id, p.id == 3, p.id == 3 ? "fell <over>" : "", {}, 1.0, true};
      if (!o.failed) o.numbers["radius_mm"] = std::stod(p.settings.at("object.ball.radius_mm"));
      rows.push_back(
          {p, o.failed ? PointStatus::failed : PointStatus::done, o, "0.9", "here", "2026-01-01T00:00:00Z"});
      out.push_back(o);
    }
    return out;
  });
  const StudyReport report = monte_carlo_report({file.head, rows, {}, {"fringetwin"}, "1"}, plan, result);
  EXPECT_THAT(report.html, HasSubstr("size &lt;s&gt;"));
  EXPECT_THAT(report.html, HasSubstr("fell &lt;over&gt;"));
  EXPECT_THAT(report.html, Not(HasSubstr("<s>")));
  EXPECT_THAT(report.html, HasSubstr("19.0"));
  EXPECT_THAT(report.html, HasSubstr(result.converged ? ">converged<" : ">not converged<"));
  // All of the variance is the radius's: the tornado's first row, and nothing of the gain.
  EXPECT_THAT(report.html, HasSubstr("<td class=\"l\">gain</td><td class=\"r\">0.000</td>"));
  ASSERT_EQ(report.figures.size(), 4u);
  EXPECT_EQ(report.figures[0].first, "radius_mm-histogram");
  EXPECT_EQ(report.figures[3].first, "radius_mm-tornado");
  EXPECT_THAT(report.figures[3].second, HasSubstr("size &lt;s>"));
}

TEST(MonteCarloReport, WhatNoTrialHasIsNotTheSameInAll) {
  MonteCarloResult result;
  result.trials = 7;
  result.numbers["missing"].summary = summarise(std::vector<double>(7, kNan), 0.95);
  result.numbers["fixed"].summary = summarise(std::vector<double>(7, 2.0), 0.95);
  const std::string html = monte_carlo_report({{}, {}, {}, {"fringetwin"}, "1"}, {}, result).html;
  EXPECT_THAT(html, HasSubstr("0 of 7 trials have this number"));
  const std::size_t same = html.find("The same in all trials");
  ASSERT_NE(same, std::string::npos);
  EXPECT_EQ(html.find("The same in all trials", same + 1), std::string::npos) << "of one number only";
}

TEST(ConvergenceSteps, EndWithTheConvergenceOfAllBlocks) {
  AdaptiveRule rule;
  rule.block_trials = 10;
  rule.digits = 1;
  std::vector<double> trials;
  for (std::uint64_t i = 0; i < 1005; ++i)
    trials.push_back(normal_quantile(unit_draw(1, DrawStream::trials, i, 0)));
  const auto steps = convergence_steps(trials, rule, 7);
  ASSERT_FALSE(steps.empty());
  EXPECT_LE(steps.size(), 8u);
  EXPECT_EQ(steps.front().trials, 20u);
  EXPECT_EQ(steps.back().trials, 1000u);
  EXPECT_EQ(steps.back().convergence.mean, convergence(trials, rule).mean);
  EXPECT_TRUE(convergence_steps({1.0, 2.0}, rule).empty());
}

}  // namespace
}  // namespace fringetwin::study::monte_carlo_report_test
