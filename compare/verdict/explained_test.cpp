// SPDX-License-Identifier: Apache-2.0
// Verdicts of the budget on made images: noise as stated is explained, more is not.
//
// | check                             | tolerance | origin                                           |
// |-----------------------------------|-----------|--------------------------------------------------|
// | chi2 of noise as stated           | 0.05      | two standard errors of 24 bins' medians, N = 4…8 |
// | chi2 of noise of 1.3 the variance | 0.02      | scatter of a variance over 2e5 values is 0.003   |
// | regional chi2 of noise            | 0.15      | 3 sqrt(2/n), n > 800 blocks                      |
#include "compare/verdict/explained.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "compare/gray/interior_mask.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::explained_test {
namespace {

using testing::SidesTruth;
using testing::SyntheticSides;

/// 12 bit, black above the clip, so that all values are usable.
SidesTruth deep() {
  SidesTruth t;
  t.width = 256;
  t.height = 240;
  t.pitches_px = {13};
  t.steps = 8;
  t.bit_depth = 12;
  t.gain_dn = 200.0;
  t.black_level_dn = 60.0;
  t.noise_dn = 4.0;
  return t;
}

ExplainedRow gray_of(const SyntheticSides& scene, const RenderingError& rendering = {}) {
  std::vector<std::string> warnings;
  const auto pairs = pair_gray(scene.twin, scene.real, scene.simulated, {}, warnings);
  const GainFit fit = fit_gain(pairs.at(0), warnings);
  const measure::CameraDecode *real = decode_of(scene.real, 0), *simulated = decode_of(scene.simulated, 0);
  const GrayNoise noise(pairs[0], real, {});
  const auto row =
      explain_gray(pairs[0], fit, noise, interior_mask(pairs[0].mask, real, simulated), simulated, rendering);
  EXPECT_TRUE(row.has_value());
  return row.value();
}

TEST(Explained, NoiseAsItIsMeasuredIsExplained) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SidesTruth t = deep();
    t.seed = seed;
    const ExplainedRow row = gray_of(testing::make_sides(t));
    EXPECT_TRUE(row.explained);
    EXPECT_NEAR(row.chi2, 1.0, 0.05);
    EXPECT_NEAR(row.regional_chi2, 1.0, 0.15);
    EXPECT_GT(row.n_regions, 300u);
    EXPECT_NEAR(row.expected() / (t.noise_dn * t.noise_dn + 1.0 / 12.0), 1.0, 0.05);
    EXPECT_EQ(row.region, "left");
  }
}

TEST(Explained, NoiseBelowTheRoundingIsExplained) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SidesTruth t;
    t.width = 256;
    t.height = 240;
    t.pitches_px = {13};
    t.steps = 8;
    t.black_level_dn = 20.0;
    t.gain_dn = 14.0;
    t.noise_dn = 0.3;
    t.seed = seed;
    const ExplainedRow row = gray_of(testing::make_sides(t));
    EXPECT_TRUE(row.explained) << row.chi2 << ' ' << row.regional_chi2;
    ASSERT_EQ(row.lines.size(), 4u);
    EXPECT_NEAR(row.lines[1].variance, 1.0 / 12.0, 1e-9);
  }
}

/// Three steps tell no noise: the twin's sensor model stands.
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
  EXPECT_TRUE(as_stated.explained);
  EXPECT_NEAR(as_stated.chi2, 1.0, 0.02);
  EXPECT_THAT(as_stated.lines.at(0).name, ::testing::HasSubstr("sensor model"));
  const ExplainedRow less_stated = gray_of(modelled(t, total_dn2 / 1.3 - 1.0 / 12.0));
  EXPECT_FALSE(less_stated.explained);
  EXPECT_NEAR(less_stated.chi2, 1.3, 0.02);
}

TEST(Explained, WhatIsCommonToARegionIsNot) {
  // 1 % of shading over half the image: 0.2 of the noise's square, but in every step and pixel alike
  SyntheticSides scene = testing::make_sides(deep());
  for (ImageF& image : scene.simulated.irradiance[0].images)
    for (int y = 0; y < image.height; ++y)
      for (int x = image.width / 2; x < image.width; ++x) image(x, y) *= 1.002F;
  const ExplainedRow row = gray_of(scene);
  EXPECT_LE(row.chi2, row.chi2_limit);
  EXPECT_GT(row.regional_chi2, 1.5 * row.regional_limit);
  EXPECT_FALSE(row.explained);
}

TEST(Explained, TheRenderersOwnErrorIsPartOfTheBudget) {
  SidesTruth t = deep();
  t.steps = 3;
  const double missing_dn2 = 0.3 * t.noise_dn * t.noise_dn;
  const SyntheticSides scene = modelled(t, t.noise_dn * t.noise_dn - missing_dn2);
  EXPECT_FALSE(gray_of(scene).explained);
  const ExplainedRow row =
      gray_of(scene, {.gray_dn = std::sqrt(missing_dn2), .phase_rad = 0.0, .estimated = true});
  EXPECT_TRUE(row.explained);
  EXPECT_NEAR(row.lines.at(2).variance, missing_dn2, 1e-9);
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
  EXPECT_FALSE(rendering_error(scene.twin.cameras[0], {other}, 1.0).estimated);
}

/// Decodes of the same surface, with Gaussian noise of a stated sigma on both sides and an offset.
struct Phases {
  measure::DirectionDecode real, simulated;
  ImageU8 interior;
};

Phases noisy_phases(double sigma_px, double offset_px, double noise_factor = 1.0) {
  SidesTruth t = deep();
  const SyntheticSides scene = testing::make_sides(t);
  Phases out{scene.real.measurement->cameras[0].directions[0],
             scene.simulated.measurement->cameras[0].directions[0],
             {}};
  out.interior = ImageU8(t.width, t.height, 0);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, sigma_px * noise_factor);
  for (measure::DirectionDecode* d : {&out.real, &out.simulated}) {
    d->finest = 0;
    d->coordinate_sigma_px = ImageF(t.width, t.height, static_cast<float>(sigma_px));
    for (double& x : d->coordinate_px.data) x += normal(random);
  }
  for (std::size_t i = 0; i < out.interior.size(); ++i)
    out.interior.data[i] = std::isnan(out.real.coordinate_px.data[i]) ? 0 : 1;
  for (double& x : out.simulated.coordinate_px.data) x += offset_px;
  return out;
}

ExplainedRow phase_of(const Phases& p, const RenderingError& rendering = {}) {
  const auto row = explain_phase("left", p.real, p.simulated, p.interior, rendering);
  EXPECT_TRUE(row.has_value());
  return row.value();
}

constexpr double kSigmaPx = 0.01;
/// Of the difference's mean over a whole block of 16 x 16 px.
const double kRegionalSigmaPx = kSigmaPx * std::numbers::sqrt2 / 16.0;

TEST(Explained, PhaseNoiseAsStatedIsExplained) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 0.0));
  EXPECT_TRUE(row.explained);
  EXPECT_NEAR(row.chi2, 1.0, 0.05);
  EXPECT_NEAR(row.regional_chi2, 1.0, 3.0 * std::sqrt(2.0 / static_cast<double>(row.n_regions)));
  const double per_px = 2.0 * std::numbers::pi / 13.0;
  EXPECT_NEAR(row.expected() / (2.0 * std::pow(kSigmaPx * per_px, 2)), 1.0, 1e-3);
  EXPECT_EQ(row.region, "left x");
}

TEST(Explained, AConstantPhaseOffsetOfThreeRegionalSigmasIsNot) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 3.0 * kRegionalSigmaPx));
  EXPECT_LE(row.chi2, row.chi2_limit);        // no single pixel tells
  EXPECT_NEAR(row.regional_chi2, 10.0, 3.0);  // 1 + 9, less where a block is cut off by the disc
  EXPECT_FALSE(row.explained);
}

TEST(Explained, TooMuchPhaseNoiseIsNot) {
  const ExplainedRow row = phase_of(noisy_phases(kSigmaPx, 0.0, std::sqrt(1.3)));
  EXPECT_NEAR(row.chi2, 1.3, 0.05);
  EXPECT_FALSE(row.explained);
}

TEST(Explained, APhaseErrorOfTheRendererIsPartOfTheBudget) {
  const double per_px = 2.0 * std::numbers::pi / 13.0;
  RenderingError rendering;
  rendering.phase_rad = 3.0 * kRegionalSigmaPx * per_px;
  EXPECT_TRUE(phase_of(noisy_phases(kSigmaPx, 3.0 * kRegionalSigmaPx), rendering).explained);
}

TEST(Explained, TooFewValuesAreNotJudged) {
  Phases p = noisy_phases(kSigmaPx, 0.0);
  std::size_t n = 0;
  for (unsigned char& m : p.interior.data) m = m != 0 && ++n <= 200 ? 1 : 0;
  EXPECT_TRUE(explain_phase("left", p.real, p.simulated, p.interior, {}).has_value());
  *std::find(p.interior.data.begin(), p.interior.data.end(), 1) = 0;
  EXPECT_FALSE(explain_phase("left", p.real, p.simulated, p.interior, {}).has_value());
}

FitRow fit_row(double z_radius, double z_center_y) {
  FitRow row;
  row.object = "ball";
  row.kind = "sphere";
  measure::ObjectFit real;
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

TEST(Explained, GeometryWithinThreeStandardErrorsIs) {
  const auto rows = explain_geometry({fit_row(1.0, -2.9), fit_row(3.1, 0.5)});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_TRUE(rows[0].explained);
  EXPECT_EQ(rows[0].worst, "center_mm.y");
  EXPECT_NEAR(rows[0].chi2, 2.9 * 2.9, 1e-12);
  EXPECT_NEAR(rows[0].observed, std::pow(0.005 * 2.9, 2), 1e-12);
  EXPECT_NEAR(rows[0].expected(), 25e-6, 1e-12);  // 3² + 4² µm²
  EXPECT_EQ(rows[0].n, 3u);                       // the unknown z is not counted
  EXPECT_FALSE(rows[1].explained);
  EXPECT_EQ(rows[1].worst, "radius_mm");
  EXPECT_EQ(rows[1].unit, "mm");
  EXPECT_EQ(all_explained(rows, "geometry"), false);
  EXPECT_EQ(all_explained({rows[0]}, "geometry"), true);
  EXPECT_EQ(all_explained(rows, "gray"), std::nullopt);
}

TEST(Explained, GeometryWithoutStandardErrorsIsNotJudged) {
  FitRow row = fit_row(1.0, 1.0);
  row.z.clear();
  row.z_vectors.clear();
  EXPECT_TRUE(explain_geometry({row}).empty());
}

}  // namespace
}  // namespace fringetwin::compare::explained_test
