// SPDX-License-Identifier: Apache-2.0
// What study_theory_test shows with a few noise seeds, with 600: standard deviations of fits within 10 % of
// the closed form, without allowance for chance. tolerance: 10 %, as asked of the studies: 3.4 standard
// errors of a standard deviation over 600 seeds.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/shipped_studies.hpp"

namespace fringetwin::testing::study_theory_full_test {
namespace {

const std::vector<std::string> kSphere = {"center_x_mm", "center_y_mm", "center_z_mm", "radius_mm"};

void expect_within_a_tenth(const std::string& study, const Replacements& replace,
                           const std::vector<std::string>& numbers, std::size_t runs = 600) {
  const auto rows = run_shipped_study(study, replace);
  ASSERT_EQ(rows.size(), runs);
  for (const auto& [name, ratio] : deviation_ratios(rows, numbers)) {
    EXPECT_NEAR(ratio, 1.0, 0.1) << study << ' ' << name;
    std::printf("%s %s: %.3f of the expected\n", study.c_str(), name.c_str(), ratio);
  }
}

TEST(StudyTheoryFull, SixHundredSeeds) {
  FT_NEED_DEVICE();
  const std::string noise = "range = [0.5, 50]\ncount = 5\nscale = \"log\"", seeds = "noise_seeds = 600";
  expect_within_a_tenth("noise-sphere", {{"noise_seeds = 200", seeds}, {noise, "values = [0.5]"}}, kSphere);
  expect_within_a_tenth("noise-sphere",
                        {{"noise_seeds = 200", seeds + "\nfirst_noise_seed = 2001"}, {noise, "values = [5]"}},
                        kSphere);
  expect_within_a_tenth("shot-noise",
                        {{"noise_seeds = 40", seeds + "\nfirst_noise_seed = 4001"},
                         {"range = [0.1, 10]\ncount = 5\nscale = \"log\"", "values = [1]"}},
                        kSphere);
  const std::string both = "values = [\"stereo\", \"projector\"]";
  for (const char* one : {"values = [\"stereo\"]", "values = [\"projector\"]"})
    expect_within_a_tenth("noise-plane", {{"noise_seeds = 100", seeds}, {noise, "values = [5]"}, {both, one}},
                          {"depth_mm"});
  const std::string stereo = "[[vary]]\nkey = \"measure.triangulate\"\nvalues = [\"stereo\"]\n[[vary]]";
  expect_within_a_tenth(
      "noise-sphere", {{"noise_seeds = 200", seeds}, {noise, "values = [5]"}, {"[[vary]]", stereo}}, kSphere);
}

// The whole cap up to the outlines of both cameras; 2.8 standard errors.
TEST(StudyTheoryFull, ThePapersSphere) {
  FT_NEED_DEVICE();
  expect_within_a_tenth("thousand",
                        {{"noise_seeds = 100", "noise_seeds = 400"},
                         {"[[8, 8, 22, 22], [12, 12, 353, 353]]", "[[12, 12, 353, 353]]"},
                         {"values = [0.5, 1, 2, 4, 8]", "values = [16]"}},
                        kSphere, 400);
}

}  // namespace
}  // namespace fringetwin::testing::study_theory_full_test
