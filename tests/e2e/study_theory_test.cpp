// SPDX-License-Identifier: Apache-2.0
// The shipped studies of rounding and noise against the closed form (docs/metrics/study.md, "Theory of the
// noise"), which renders, decodes and fits nothing. tolerance: rms 1 % for noise (measured: 0.6 %,
// docs/STUDIES.md), 7 % for rounding alone, which without noise is not random (measured: 6 %); standard
// deviations over noise seeds: the 10 % asked of the studies and 2.6 of their own standard errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "study/kind/check_study.hpp"
#include "study/study_file.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/shipped_studies.hpp"

namespace fringetwin::testing::study_theory_test {
namespace {

namespace fs = std::filesystem;

void expect_rms(const std::map<std::string, std::vector<StudyRow>>& groups, double tolerance = 0.01) {
  for (const auto& [name, rows] : groups)
    EXPECT_NEAR(mean(rows, "rms_mm") / mean(rows, "rms_mm.expected_mean"), 1.0, tolerance) << name;
}

const std::string kBits = "camera.left.sensor.bit_depth";

/// Up to so many bits rounding rules; beyond, what the theory leaves out does.
void expect_rounding(const std::string& study, int bits_projector, int bits_stereo) {
  const auto groups = grouped(run_shipped_study(study, {}), {"measure.triangulate", kBits});
  ASSERT_EQ(groups.size(), 18u);
  for (const auto& [name, rows] : groups) {
    const bool stereo = name.find("stereo") != std::string::npos;
    if (number(rows[0], kBits) <= (stereo ? bits_stereo : bits_projector)) expect_rms({{name, rows}}, 0.07);
  }
}

TEST(StudyTheory, RoundingOverTwoDecades) {
  FT_NEED_DEVICE();
  // with two cameras the interpolation between their pixels remains
  expect_rounding("bit-depth-plane", 15, 14);
  expect_rounding("bit-depth-sphere", 16, 15);
}

/// Two decades of noise in three levels, each with draws of its own.
void expect_scatter(const std::string& study, const std::string& seeds, const Replacements& more,
                    const std::vector<std::string>& numbers) {
  constexpr int n = 36, levels = 3;
  const auto tolerance = [](int draws) { return 0.1 + 2.6 / std::sqrt(2.0 * (draws - 1)); };
  std::map<std::string, double> ratio2;
  for (int level = 0; level < levels; ++level) {
    Replacements all = more;
    all.emplace_back(seeds, "noise_seeds = " + std::to_string(n) +
                                "\nfirst_noise_seed = " + std::to_string(1 + 1000 * level));
    all.emplace_back(
        "range = [0.5, 50]\ncount = 5\nscale = \"log\"",
        "values = [" + std::vector<std::string>{"0.5", "5", "50"}.at(static_cast<std::size_t>(level)) + "]");
    const std::vector<StudyRow> rows = run_shipped_study(study, all);
    ASSERT_EQ(rows.size(), static_cast<std::size_t>(n));
    expect_rms({{study + " level " + std::to_string(level), rows}});
    for (const auto& [name, ratio] : deviation_ratios(rows, numbers)) {
      EXPECT_NEAR(ratio, 1.0, tolerance(n)) << study << ' ' << name << " at level " << level;
      ratio2[name] += ratio * ratio / levels;
    }
  }
  for (const auto& [name, value] : ratio2)
    EXPECT_NEAR(std::sqrt(value), 1.0, tolerance(levels * n)) << study << ' ' << name;
}

TEST(StudyTheory, NoiseOfAPlaneOverTwoDecades) {
  FT_NEED_DEVICE();
  expect_scatter("noise-plane", "noise_seeds = 100",
                 {{"values = [\"stereo\", \"projector\"]", "values = [\"projector\"]"}}, {"depth_mm"});
}

TEST(StudyTheory, NoiseOfASphereOverTwoDecades) {
  FT_NEED_DEVICE();
  expect_scatter("noise-sphere", "noise_seeds = 200", {},
                 {"center_x_mm", "center_y_mm", "center_z_mm", "radius_mm"});
}

TEST(StudyTheory, ShotNoiseOfASphereOverTwoDecades) {
  FT_NEED_DEVICE();
  expect_rms(grouped(run_shipped_study("shot-noise", {{"noise_seeds = 40", "noise_seeds = 3"}}),
                     {"camera.left.sensor.electrons_per_dn"}));
}

// Which points there are is the theory's, too: what border pixels cost, and the pixels between which the
// second camera is read. tolerance of n: a ring of a pixel around the cap is 1.4 % of its points.
TEST(StudyTheory, ThePapersSphereUpToItsOutlines) {
  FT_NEED_DEVICE();
  const auto rows =
      run_shipped_study("thousand", {{"noise_seeds = 100", "noise_seeds = 3"},
                                     {"[[8, 8, 22, 22], [12, 12, 353, 353]]", "[[12, 12, 353, 353]]"},
                                     {"values = [0.5, 1, 2, 4, 8]", "values = [16]"},
                                     {"[[record]]",
                                      "[[record]]\nresult = \"fits.sphere.measured.n\"\n"
                                      "name = \"n\"\nexpected_mean = \"theory.sphere.n\"\n"
                                      "[[record]]"}});
  expect_rms({{"12 bit, 16 DN", rows}});
  EXPECT_NEAR(mean(rows, "n") / mean(rows, "n.expected_mean"), 1.0, 0.01);
}

TEST(StudyTheory, EveryShippedStudyCanBeRun) {
  int n = 0;
  for (const auto& entry : fs::directory_iterator(shipped_studies())) {
    if (read_file(entry.path()).find("fringetwin-study/1") == std::string::npos) continue;
    const study::StudyFile file = study::load_study(entry.path());
    EXPECT_NO_THROW(study::check_study(file.head, study::kind_of(file)->plan())) << file.head.file;
    ++n;
  }
  EXPECT_GE(n, 14);
}

}  // namespace
}  // namespace fringetwin::testing::study_theory_test
