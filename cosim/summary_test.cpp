// SPDX-License-Identifier: Apache-2.0
// No tolerances: sentences. The numbers in them differ from each other everywhere, so that an exchange shows.
#include "cosim/summary.hpp"

#include <gtest/gtest.h>

#include "twin/base/constants.hpp"

namespace fringetwin::cosim::summary_test {
namespace {

using Lines = std::vector<std::string>;

TEST(Summary, NothingFoundIsNothingSaid) { EXPECT_EQ(summary_lines({}), Lines{}); }

compare::GainRow gain_of(const std::string& camera, const std::string& why) {
  compare::GainRow row;
  row.camera = camera, row.why = why;
  return row;
}

TEST(Summary, SaysGainAndResidualOfEachCamera) {
  compare::GainRow left = gain_of("left", "is not said where a gain is fitted");
  left.usable = true, left.state = "biased";
  left.gain_dn = 17.31, left.gain_sigma_dn = 0.2;
  left.black_level_dn = 4.25, left.black_level_sigma_dn = 0.5;
  left.rms_before_dn = 9.75, left.rms_after_dn = 1.5, left.r2 = 0.987;
  compare::GainRow right = left;
  right.camera = "right", right.state = "sensor value";
  right.rms_before_dn = kNaN;
  compare::Comparison c;
  c.gain = {left, right, gain_of("top", "all values are clipped"), gain_of("low", "")};
  EXPECT_EQ(
      summary_lines(c),
      (Lines{
          "left: gain 17.3100 +- 0.2 DN, black 4.25 DN (biased), residual 9.75 -> 1.50 DN rms, R2 0.987",
          "right: gain 17.3100 +- 0.2 DN, black 4.25 DN (sensor value), residual - -> 1.50 DN rms, R2 0.987",
          "top: no gain fitted: all values are clipped", "low: no gain fitted"}));
}

// Of the budget, the roots of the mean squares are said, and the share of the variance about the mean:
// (0.01^2 + 0.02^2 + 0.03^2) / (0.003 - 0.0002) = 50 %.
TEST(Summary, SaysPhaseAndItsBudget) {
  compare::Comparison c;
  c.phase = {{.camera = "left",
              .direction = "y",
              .mean_rad = 0.0625,
              .rms_rad = 0.03125,
              .p99_rad = 0.125,
              .mean_relative = 0.0025,
              .n = 321,
              .n_order_disagree = 12}};
  c.phase_budget = {{.camera = "right",
                     .direction = "x",
                     .total_rad2 = 3e-3,
                     .offset_rad2 = 2e-4,
                     .brightness_rad2 = 1e-4,
                     .harmonic_rad2 = 4e-4,
                     .noise_rad2 = 9e-4}};
  EXPECT_EQ(summary_lines(c),
            (Lines{"left y: phase difference 0.03125 rad rms, 0.2500 % relative mean, n 321",
                   "right x: brightness 0.0100, harmonics 0.0200, noise 0.0300 rad rms: 50 % of the "
                   "difference's variance"}));
}

TEST(Summary, SaysWhereNoPhaseIsCompared) {
  compare::Comparison c;
  c.phase = {{.camera = "left", .direction = "y"}};
  EXPECT_EQ(summary_lines(c), (Lines{"left y: no pixel has a phase on both sides"}));
}

// 600 of 1000 pixels seen are measured on both sides; 150 + 50 of the 800 measured on one only.
TEST(Summary, SaysCoverageOfWholeCamerasOnly) {
  compare::Comparison c;
  compare::CoverageRow row;
  row.camera = "left";
  row.n_both = 600, row.n_seen = 1000;
  row.real_only.n = 150, row.simulated_only.n = 50;
  compare::CoverageRow of_object = row;
  of_object.object = "ball";
  c.coverage = {of_object, row};
  EXPECT_EQ(summary_lines(c),
            (Lines{"coverage left: 60.0 % of the pixels seen are measured on both sides, 25.00 % of the "
                   "measured on one side only"}));
}

compare::ExplainedRow judged(const std::string& quantity, const char* state, const std::string& why = "") {
  compare::ExplainedRow row;
  row.quantity = quantity, row.region = "region of " + quantity;
  row.state = state, row.why = why;
  return row;
}

TEST(Summary, SaysEveryState) {
  compare::Comparison c;
  c.explained = {judged("gray", compare::kExplained), judged("phase", compare::kNotExplained, "ripple"),
                 judged("geometry", compare::kTooWide), judged("coverage", compare::kNotCompared, "dark")};
  c.explained[0].chi2 = 1.25, c.explained[0].chi2_limit = 1.5;
  c.explained[0].regional_chi2 = 1.75, c.explained[0].regional_limit = 2.25;
  c.explained[1].chi2 = 3.5, c.explained[1].chi2_limit = 1.375;
  c.explained[2].regional_chi2 = 0.25, c.explained[2].regional_limit = 4.5;
  EXPECT_EQ(summary_lines(c),
            (Lines{"gray region of gray: explained, chi2 1.25 (limit 1.5), of regions 1.75 (2.25)",
                   "phase region of phase: NOT EXPLAINED by the budget, chi2 3.5 (limit 1.38): ripple",
                   "geometry region of geometry: BUDGET TOO WIDE, of regions 0.25 (4.5)",
                   "coverage region of coverage: NOT COMPARED: dark"}));
}

// The page has all sentences on coverage, the terminal those on the three that are furthest off.
TEST(Summary, SaysTheWorstThreeOfCoverage) {
  compare::Comparison c;
  c.explained = {judged("coverage", compare::kNotExplained, "all of it")};
  c.explained[0].region = "left";
  for (const std::uint64_t thick : {20u, 10u, 40u, 30u}) {
    compare::CoverageRow& row = c.coverage.emplace_back();
    row.camera = "left", row.object = "n" + std::to_string(thick), row.why = "differs";
    row.real_only.thick = thick, row.allowed_thick = 9.0;
  }
  c.coverage.emplace_back(c.coverage[2]).camera = "right";
  EXPECT_EQ(summary_lines(c),
            (Lines{"coverage left: NOT EXPLAINED by the budget: of \"n40\" differs; of \"n30\" differs; of "
                   "\"n20\" differs; and 1 more (see the page)"}));
  c.coverage.erase(c.coverage.begin());
  EXPECT_EQ(summary_lines(c), (Lines{"coverage left: NOT EXPLAINED by the budget: all of it"}));
}

// What is left over is said after the causes, and the gain with a cause after both.
TEST(Summary, SaysCausesThenWhatIsLeftThenTheGainWithThem) {
  compare::Comparison c;
  c.causes.rows.resize(1);
  c.causes.rows[0].group = "pose";
  c.causes.rows[0].cause = "pose of the ball";
  c.causes.rows[0].alone = 0.75;
  c.causes.together = {"pose"};
  c.causes.pattern.resize(1);  // of order 0: nothing is named
  c.causes.why = "they go along with each other";
  const Lines lines = summary_lines(c);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_NE(lines[0].find("most likely cause: pose of the ball; it explains 75.0 %"), std::string::npos)
      << lines[0];
  EXPECT_NE(lines[1].find("no pattern found"), std::string::npos) << lines[1];
  EXPECT_EQ(lines[2], "no gain or black level is offered with pose: they go along with each other");
}

TEST(Summary, SaysSimulatedScatterAndDifferencesOfTheFits) {
  compare::Comparison c;
  c.fits.resize(3);
  c.fits[0].object = "ball";
  c.fits[0].simulated = measure::ObjectFit{
      .object = "ball",
      .usable = true,
      .n = 400,
      .numbers = {{"rms_mm", 0.0015}, {"rms_all_mm", 0.0025}, {"n_gated", 450.0}, {"radius_mm", 5.0}}};
  c.fits[0].real = measure::ObjectFit{
      .object = "ball", .usable = true, .n = 390, .numbers = {{"rms_mm", 0.25}, {"rms_all_mm", 0.75}}};
  c.fits[0].difference = {{"radius_mm", -0.125}, {"rms_mm", 0.375}};
  c.fits[1] = c.fits[0];
  c.fits[1].object = "not usable";
  c.fits[1].simulated->usable = false;
  c.fits[1].difference.clear();
  c.fits[2].object = "published";
  c.fits[2].real = c.fits[0].real;
  EXPECT_EQ(
      summary_lines(c),
      (Lines{"ball: simulated rms 0.001500 mm on 400 points, 0.002500 mm on all 450 within the gate",
             "ball: radius_mm simulated - real = -0.125000", "ball: rms_mm simulated - real = 0.375000"}));
}

TEST(Summary, SaysWhichLimitsAreMet) {
  compare::Comparison c;
  c.limits = {{.name = "phase_rms_rad", .value = 0.03125, .limit = 0.05, .pass = true},
              {.name = "gray_rms_dn", .value = 2.25, .limit = 1.5, .pass = false}};
  EXPECT_EQ(summary_lines(c),
            (Lines{"limit phase_rms_rad = 0.05: 0.03125 pass", "limit gray_rms_dn = 1.5: 2.25 FAIL"}));
}

measure::ObjectFit fit(const std::string& object, bool usable, std::size_t n) {
  return {.object = object, .usable = usable, .warning = "why " + object, .n = n};
}

// Twenty points are enough (docs/formats/results.md, "Fits"); with fewer it is a warning and no failure.
TEST(ConvergenceFault, IsOfTheFirstFitThatHadEnoughPoints) {
  measure::Measurement m;
  EXPECT_EQ(convergence_fault(m), "");
  m.fits = {fit("good", true, 500), fit("few", false, 19)};
  EXPECT_EQ(convergence_fault(m), "");
  m.fits.push_back(fit("first", false, 20));
  m.fits.push_back(fit("second", false, 300));
  EXPECT_EQ(convergence_fault(m), "the fit of \"first\" did not converge: why first");
}

}  // namespace
}  // namespace fringetwin::cosim::summary_test
