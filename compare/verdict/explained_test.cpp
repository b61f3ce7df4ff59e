// SPDX-License-Identifier: Apache-2.0
// Verdicts of the budget on made images: noise as stated is explained, more is not.
//
// | check                             | tolerance | origin                                           |
// |-----------------------------------|-----------|--------------------------------------------------|
// | chi2 of noise as stated           | 0.05      | 5 times what the noise is known to, 1 % (N = 4…8) |
// | chi2 of noise of 1.3 the variance | 0.02      | scatter of a variance over 2e5 values is 0.003   |
// | regional chi2 of noise            | 0.15      | 3 sqrt(2/n), n > 800 blocks                      |
// | of scatter not in the budget      | 0.5       | the same, times 3.17                             |
// | chi2 of a quarter of the variance | 0.005     | scatter of a variance over 1e5 values is 0.0045  |
// | factor of that, gray              | 0.02      | half of that, times 2                            |
#include "compare/verdict/explained.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "compare/gray/interior_mask.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::explained_test {
namespace {

using testing::SidesTruth;
using testing::SyntheticSides;

SidesTruth one_pitch(SidesTruth t) {
  t.width = 256;
  t.height = 240;
  t.pitches_px = {13};
  t.steps = 8;
  return t;
}
SidesTruth deep() { return one_pitch(testing::deep_truth(60.0)); }

ExplainedRow gray_of(SyntheticSides scene, const RenderingError& rendering = {}) {
  const testing::FittedGray gray(std::move(scene));
  const measure::CameraDecode *real = gray.real_decode(), *simulated = gray.simulated_decode();
  return explain_gray(gray.pair, gray.fit, gray.noise(), interior_mask(gray.pair.mask, real, simulated),
                      simulated, rendering, {}, seen_pixels(real, simulated));
}

// Quantiles of chi^2/n at 3 sigma of a normal number, one in 740 (scipy.stats.chi2.ppf(norm.cdf(3), n) / n).
// Tolerance: what the approximation promises, 3 % of the distance from 1 with one degree of freedom.
TEST(Explained, AllowsWhatChanceReachesWithFewSquares) {
  for (const auto& [n, quantile] : {std::pair{1.0, 10.273018},
                                    {2.0, 6.607726},
                                    {7.0, 3.368604},
                                    {20.0, 2.217591},
                                    {100.0, 1.477936},
                                    {100'000.0, 1.013470}})
    EXPECT_NEAR((1.0 + allowed_above(n, 0.0)) / quantile, 1.0, n < 5.0 ? 0.03 : 0.01) << n;
  EXPECT_NEAR(allowed_above(1e12, 0.02), 0.06, 1e-5);
  EXPECT_NEAR(allowed_above(7.0, 0.1), std::hypot(allowed_above(7.0, 0.0), 0.3), 1e-12);
}

TEST(Explained, NoiseAsItIsMeasuredIsExplained) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SidesTruth t = deep();
    t.seed = seed;
    const ExplainedRow row = gray_of(testing::make_sides(t));
    EXPECT_TRUE(row.explained());
    EXPECT_NEAR(row.chi2, 1.0, 0.05);
    EXPECT_NEAR(row.regional_chi2, 1.0, 0.15);
    EXPECT_GT(row.n_regions, 300u);
    EXPECT_NEAR(row.expected() / (t.noise_dn * t.noise_dn + 1.0 / 12.0), 1.0, 0.05);
    EXPECT_EQ(row.region, "left");
    EXPECT_EQ(row.state, "explained");
    EXPECT_EQ(row.why, "");
    EXPECT_GT(row.compared_fraction, 0.9);
    EXPECT_NEAR(row.noise_chi2, row.chi2, 1e-9);  // nothing else is in this budget
    // 1 - 3 sqrt(2/n + 0.01^2 + u^2), n = 3e5; 2e5 values leave the noise unknown to u = 0.004 or a little
    // more
    EXPECT_NEAR(row.chi2_least, 0.967, 0.004);
  }
}

TEST(Explained, NoiseBelowTheRoundingIsExplained) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SidesTruth t = one_pitch({});
    t.black_level_dn = 20.0;
    t.gain_dn = 14.0;
    t.noise_dn = 0.3;
    t.seed = seed;
    const ExplainedRow row = gray_of(testing::make_sides(t));
    EXPECT_TRUE(row.explained()) << row.chi2 << ' ' << row.regional_chi2;
    ASSERT_EQ(row.lines.size(), 4u);
    EXPECT_NEAR(row.lines[1].variance, 1.0 / 12.0, 1e-9);
  }
}

/// Three steps of one pitch tell no noise apart from texture: the twin's sensor model stands.
SyntheticSides modelled(const SidesTruth& t, double stated_dn2) {
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.cameras[0].sensor.read_noise_dn = std::sqrt(stated_dn2);
  return scene;
}

TEST(Explained, MoreNoiseThanTheSensorModelStatesIsNot) {
  SidesTruth t = deep();
  t.steps = 3;
  const double total_dn2 = t.noise_dn * t.noise_dn + 1.0 / 12.0;
  const ExplainedRow as_stated = gray_of(modelled(t, t.noise_dn * t.noise_dn));
  EXPECT_TRUE(as_stated.explained());
  EXPECT_NEAR(as_stated.chi2, 1.0, 0.02);
  EXPECT_THAT(as_stated.lines.at(0).name, ::testing::HasSubstr("sensor model"));
  const ExplainedRow less_stated = gray_of(modelled(t, total_dn2 / 1.3 - 1.0 / 12.0));
  EXPECT_FALSE(less_stated.explained());
  EXPECT_NEAR(less_stated.chi2, 1.3, 0.02);
}

TEST(Explained, LessNoiseThanTheSensorModelStatesMakesTheBudgetTooWide) {
  SidesTruth t = deep();
  t.steps = 3;
  const double total_dn2 = t.noise_dn * t.noise_dn + 1.0 / 12.0;
  const ExplainedRow row = gray_of(modelled(t, 4.0 * total_dn2 - 1.0 / 12.0));
  EXPECT_NEAR(row.noise_chi2, 0.25, 0.005);
  EXPECT_EQ(row.state, "budget too wide");
  EXPECT_FALSE(row.explained());
  EXPECT_NEAR(row.too_wide_factor, 2.0, 0.02);
  EXPECT_THAT(row.why, ::testing::HasSubstr("0.50 of what the noise in the budget says"));
  EXPECT_TRUE(row.states_noise);
}

TEST(Explained, ARenderingErrorDoesNotMakeTheNoiseTooWide) {
  SidesTruth t = deep();
  t.steps = 3;
  const ExplainedRow row = gray_of(modelled(t, t.noise_dn * t.noise_dn),
                                   {.gray_dn = 3.0 * t.noise_dn, .phase_rad = 0.0, .estimated = true});
  EXPECT_LT(row.chi2, 0.2);
  EXPECT_EQ(row.state, "explained");
}

TEST(Explained, SidesThatRoundAlikeAreNotTooWide) {
  SidesTruth t = deep();
  t.noise_dn = 0.0;
  SyntheticSides scene = testing::make_sides(t);
  scene.simulated.images = scene.real.images;  // the very same gray values
  scene.simulated.irradiance.clear();
  const ExplainedRow row = gray_of(scene);
  EXPECT_LT(row.chi2, 1e-6);
  EXPECT_EQ(row.state, "explained");
  EXPECT_TRUE(std::isnan(row.chi2_least));
}

/// Three steps at three pitches; the twin states `factor` times the noise.
SyntheticSides three_pitches(double factor) {
  SidesTruth t = deep();
  t.steps = 3;
  t.pitches_px = {13, 14, 15};
  return modelled(t, factor * factor * (t.noise_dn * t.noise_dn + 1.0 / 12.0) - 1.0 / 12.0);
}

TEST(Explained, ThreeStepsAtSeveralPitchesTellTheirNoise) {
  for (const double factor : {0.5, 1.0, 6.0}) {  // whatever the twin says
    const ExplainedRow row = gray_of(three_pitches(factor));
    EXPECT_EQ(row.state, "explained") << row.chi2;
    EXPECT_NEAR(row.chi2, 1.0, 0.05);
    EXPECT_FALSE(row.states_noise);
    EXPECT_THAT(row.lines.at(0).name, ::testing::HasSubstr("the pitches' means"));
  }
}

TEST(Explained, LessThanHalfOfThePixelsIsNotCompared) {
  SyntheticSides scene = testing::make_sides(deep());
  ImageU8& flags = scene.real.measurement->cameras[0].flags;
  const auto lose = [&](double fraction) {
    for (int y = 0; y < static_cast<int>(fraction * flags.height); ++y)
      for (int x = 0; x < flags.width; ++x)
        if (flags(x, y) == measure::kValid) flags(x, y) = measure::kSaturated;
    return gray_of(scene);
  };
  EXPECT_EQ(lose(0.4).state, "explained");
  const ExplainedRow row = lose(0.6);
  EXPECT_LE(row.chi2, row.chi2_limit);
  EXPECT_EQ(row.state, "not compared");
  EXPECT_FALSE(row.explained());
  EXPECT_NEAR(row.compared_fraction, 0.37, 0.03);  // of a disc: 0.5 - (asin h + h sqrt(1-h^2))/pi, h = 0.22
  EXPECT_THAT(row.why, ::testing::HasSubstr("% of the pixels that a side sees"));
}

TEST(Explained, MostGrayValuesAtTheEndsOfTheScaleAreNotCompared) {
  SidesTruth t = deep();
  t.steps = 3;
  t.weight = 60.0;  // 12,000 DN of 4095: most steps saturate
  const ExplainedRow row = gray_of(modelled(t, t.noise_dn * t.noise_dn));
  EXPECT_LT(row.compared_fraction, 0.5);
  EXPECT_EQ(row.state, "not compared");
  EXPECT_THAT(row.why, ::testing::HasSubstr("% of the gray values"));
}

TEST(Explained, WhatIsCommonToARegionIsNot) {
  // 0.1 % of shading over half the image: 2 % of the noise's square, but in every step and pixel alike
  SyntheticSides scene = testing::make_sides(deep());
  for (GrayImage& image : scene.simulated.irradiance[0].images)
    for (int y = 0; y < image.height; ++y)
      for (int x = image.width / 2; x < image.width; ++x) image.writable(x, y) *= 1.001F;
  const ExplainedRow row = gray_of(scene);
  EXPECT_LE(row.chi2, row.chi2_limit);
  EXPECT_GT(row.regional_chi2, 1.5 * row.regional_limit);
  EXPECT_FALSE(row.explained());
}

TEST(Explained, TheRenderersOwnErrorIsPartOfTheBudget) {
  SidesTruth t = deep();
  t.steps = 3;
  const double missing_dn2 = 0.3 * t.noise_dn * t.noise_dn;
  const SyntheticSides scene = modelled(t, t.noise_dn * t.noise_dn - missing_dn2);
  EXPECT_FALSE(gray_of(scene).explained());
  const ExplainedRow row =
      gray_of(scene, {.gray_dn = std::sqrt(missing_dn2), .phase_rad = 0.0, .estimated = true});
  EXPECT_TRUE(row.explained());
  EXPECT_NEAR(row.lines.at(2).variance, missing_dn2, 1e-9);
}

/// Errors of every pixel's own, alike in its images or turning with the fringe: common + a cos d + b sin d,
/// all normal; a and b of the same sigma. Directions of bounces leave such errors.
struct Scatter {
  double common_dn, turning_dn;
  Eigen::MatrixXd covariance(const std::vector<double>& steps_rad) const {
    const auto n = static_cast<Eigen::Index>(steps_rad.size());
    return Eigen::MatrixXd::NullaryExpr(n, n, [&](Eigen::Index k, Eigen::Index l) {
      return common_dn * common_dn + turning_dn * turning_dn * std::cos(steps_rad[k] - steps_rad[l]);
    });
  }
};

TEST(Explained, WhatIsOffInAPixelAsAWholeAddsUpOverItsImagesNotOverPixels) {
  const SidesTruth t = deep();
  const Scatter scatter{2.0, 3.0};
  SyntheticSides scene = testing::make_sides(t);
  std::vector<double> steps_rad;
  for (int k = 0; k < t.steps; ++k) steps_rad.push_back(2.0 * std::numbers::pi * k / t.steps);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < scene.real.images[0].images[0].size(); ++i) {
    const double common = scatter.common_dn * normal(random), a = scatter.turning_dn * normal(random),
                 b = scatter.turning_dn * normal(random);
    for (int k = 0; k < t.steps; ++k)
      scene.real.images[0].images[k].as_floats()[i] +=
          static_cast<float>(std::round(common + a * std::cos(steps_rad[k]) + b * std::sin(steps_rad[k])));
  }
  // a pixel's 8 values add up to a variance of 8 v + 64 c^2, by cos(d + phase) to 4 v + 16 r^2; v = 4^2 + 1/6
  const double v = t.noise_dn * t.noise_dn + 1.0 / 6.0, level = 8.0 * 4.0 / v, fringe = 4.0 * 9.0 / v;
  const ExplainedRow unstated = gray_of(scene);
  EXPECT_NEAR(unstated.regional_chi2, 1.0 + (level + 2.0 * fringe) / 3.0, 0.5);
  const RenderingError stated{.estimated = true, .scatter_dn2 = scatter.covariance(steps_rad)};
  const ExplainedRow row = gray_of(scene, stated);
  EXPECT_NEAR(row.chi2, 1.0, 0.05);
  EXPECT_NEAR(row.regional_chi2, 1.0, 0.15);
  EXPECT_EQ(row.state, "explained") << row.why;
  EXPECT_NEAR(row.lines.at(2).variance, 4.0 + 9.0, 1e-9);
  // what all pixels have in common shows through it
  for (GrayImage& image : scene.simulated.irradiance[0].images)
    for (int y = 0; y < image.height; ++y)
      for (int x = image.width / 2; x < image.width; ++x) image.writable(x, y) *= 1.002F;
  EXPECT_GT(gray_of(scene, stated).regional_chi2, 1.5 * row.regional_limit);
}

TEST(Explained, RenderingErrorIsReadFromTheNoteOfItsCamera) {
  const SyntheticSides scene = testing::make_sides(deep());
  RenderNote other, own;
  other.camera = "right";
  other.gray_error = 1.0;
  own.camera = "left";
  own.gray_error = 1e-3;
  own.phase_error_rad = 2e-4;
  const RenderingError error =
      rendering_error(scene.twin.cameras[0], {other, own}, scene.twin.cameras[0].sensor.gain_dn);
  EXPECT_TRUE(error.estimated);
  EXPECT_NEAR(error.gray_dn, 4.095, 1e-9);
  EXPECT_EQ(error.phase_rad, 2e-4);
  own.gray_inside_error = 1e-5;  // interior pixels are judged: the edges' error is not theirs
  EXPECT_NEAR(
      rendering_error(scene.twin.cameras[0], {other, own}, scene.twin.cameras[0].sensor.gain_dn).gray_dn,
      0.04095, 1e-9);
  EXPECT_FALSE(rendering_error(scene.twin.cameras[0], {other}, 1.0).estimated);
}

FitRow fit_row(double z_radius, double z_center_y) {
  FitRow row;
  row.object = "ball";
  row.kind = "sphere";
  measure::ObjectFit real;
  real.usable = true;
  real.numbers = {{"radius_sigma_mm", 0.003}};
  real.vectors = {{"center_sigma_mm", {0.001, 0.003, 0.001}}};
  row.real = real;
  real.numbers["radius_sigma_mm"] = 0.004;
  real.vectors["center_sigma_mm"].y() = 0.004;
  row.simulated = real;
  row.z = {{"radius_mm", z_radius}};
  row.difference = {{"radius_mm", 0.005 * z_radius}};
  row.z_vectors = {{"center_mm", {0.1, z_center_y, kNaN}}};
  row.difference_vectors = {{"center_mm", {0.0001, 0.005 * z_center_y, 0.7}}};
  return row;
}

// The limit is 3.21 standard errors of a single number, 3.60 of the largest of three
// (docs/metrics/verdict.md).
TEST(Explained, GeometryWithinItsStandardErrorsIs) {
  EXPECT_NEAR(most_sigmas_of(1), 3.21, 0.005);
  const auto rows = explain_geometry({fit_row(1.0, -3.5), fit_row(3.7, 0.5)});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_TRUE(rows[0].explained());
  EXPECT_EQ(rows[0].worst, "center_mm.y");
  EXPECT_NEAR(rows[0].chi2, 3.5 * 3.5, 1e-12);
  EXPECT_NEAR(std::sqrt(rows[0].chi2_limit), 3.60, 0.005);
  EXPECT_NEAR(rows[0].observed, std::pow(0.005 * 3.5, 2), 1e-12);
  EXPECT_NEAR(rows[0].expected(), 25e-6, 1e-12);  // 3² + 4² µm²
  EXPECT_EQ(rows[0].n, 3u);                       // the unknown z is not counted
  EXPECT_FALSE(rows[1].explained());
  EXPECT_EQ(rows[1].worst, "radius_mm");
  EXPECT_EQ(rows[1].unit, "mm");
  EXPECT_EQ(worst_state(rows, "geometry"), "not explained");
  EXPECT_EQ(worst_state({rows[0]}, "geometry"), "explained");
  EXPECT_EQ(worst_state(rows, "gray"), "");
}

TEST(Explained, GeometryWithoutStandardErrorsIsNotCompared) {
  FitRow row = fit_row(1.0, 1.0);
  row.z.clear();
  row.z_vectors.clear();
  const auto rows = explain_geometry({row});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].state, "not compared");
  EXPECT_EQ(rows[0].region, "ball");
  EXPECT_THAT(rows[0].why, ::testing::HasSubstr("no standard error"));
}

TEST(Explained, GeometryThatOneSideLacksIsNotCompared) {
  FitRow row = fit_row(1.0, 1.0);
  row.real->usable = false;
  row.real->n = 12;
  row.real->warning = "only 12 points";
  EXPECT_EQ(explain_geometry({row}).at(0).why, "real fit on 12 points: only 12 points");
  row.simulated.reset();
  EXPECT_EQ(explain_geometry({row}).at(0).why, "the simulated side has no fit");
  row.real.reset();  // nothing was measured: nothing to compare
  EXPECT_TRUE(explain_geometry({row}).empty());
}

}  // namespace
}  // namespace fringetwin::compare::explained_test
