// SPDX-License-Identifier: Apache-2.0
// Truth: the variance of each part as put in, evaluated on the same gray values.
// | check                        | tolerance              | origin                                        |
// |------------------------------|------------------------|-----------------------------------------------|
// | one cause at a time          | 6 % of that part       | sequential removal: causes are not orthogonal |
// | parts that were not put in   | 3 % of the total       | scatter of a variance over 1e5 values, margins |
// | the parts' sum               | 1e-9 of the total      | by construction                               |
#include "compare/gray/gray_budget.hpp"

#include <gtest/gtest.h>

#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gray_budget_test {
namespace {

using testing::FittedGray;
using testing::SidesTruth;
using testing::SyntheticSides;

GrayBudget budget_of(const FittedGray& gray, const GrayNoise& noise, const ShadingNoise& shading = {}) {
  const auto budget =
      gray_budget(gray.pair, gray.fit, gray.real_decode(), gray.simulated_decode(), noise, shading);
  EXPECT_TRUE(budget.has_value());
  return budget.value();
}
GrayBudget budget_of(SyntheticSides scene) {
  const FittedGray gray(std::move(scene));
  return budget_of(gray, gray.noise());
}
GrayBudget budget_of(const SidesTruth& t) { return budget_of(testing::make_sides(t)); }

double sum_of_parts(const GrayBudget& b) {
  return b.noise_dn2 + b.albedo_dn2 + b.harmonics_dn2 + b.geometry_dn2 + b.rest_dn2;
}

/// Mean square of gain E over the lit pixels, roughly: E = w/2 (1 + cos).
double mean_square_signal(const SidesTruth& t, double harmonic_weight) {
  double sum = 0, n = 0;
  for (int y = 0; y < t.height; ++y)
    for (int x = 0; x < t.width; ++x)
      if (testing::is_lit(t, x, y)) {
        const double level = 0.5 * t.gain_dn * testing::weight_at(t, x, y);
        sum += level * level * harmonic_weight, n += 1;
      }
  return sum / n;
}

/// No value near the clip at 0: all steps enter.
SidesTruth unclipped_truth(int steps) {
  SidesTruth t;
  t.steps = steps;
  t.black_level_dn = 20.0;
  t.gain_dn = 14.0;
  return t;
}

TEST(GrayBudget, NoiseAloneIsCalledNoise) {
  SidesTruth t;
  t.steps = 8;
  const GrayBudget b = budget_of(t);
  const double truth = t.noise_dn * t.noise_dn + 1.0 / 12.0;
  EXPECT_NEAR(b.noise_dn2 / truth, 1.0, 0.03);
  EXPECT_NEAR(b.total_dn2 / truth, 1.0, 0.03);
  for (double part : {b.albedo_dn2, b.harmonics_dn2, b.geometry_dn2, b.rest_dn2})
    EXPECT_NEAR(part / b.total_dn2, 0.0, 0.03);
  EXPECT_NEAR(sum_of_parts(b) / b.total_dn2, 1.0, 1e-9);
  EXPECT_NE(b.noise_source.find("phase steps"), std::string::npos);
}

TEST(GrayBudget, AlbedoIsFound) {
  SidesTruth t = unclipped_truth(8);
  t.albedo_sigma = 0.05;
  const GrayBudget b = budget_of(t);
  const double truth = 0.05 * 0.05 * mean_square_signal(t, 1.5);  // mean of (1 + cos)² is 1.5
  EXPECT_NEAR(b.albedo_dn2 / truth, 1.0, 0.06);
  EXPECT_NEAR(b.albedo_sigma, 0.05, 0.004);
  EXPECT_NEAR(b.rest_dn2 / b.total_dn2, 0.0, 0.03);
  EXPECT_NEAR(b.harmonics_dn2 / b.total_dn2, 0.0, 0.03);
}

// Of factors that scatter by 5 % per pixel the noise of a shape predicts 3 %: that is no reflectivity.
TEST(GrayBudget, ShadingByTheNoiseOfAShapeStandsByItself) {
  SidesTruth t = unclipped_truth(8);
  t.albedo_sigma = 0.05;
  const FittedGray gray(testing::make_sides(t));
  const auto of_shading = [&](double relative, double ambient) {
    return budget_of(gray, gray.noise(), {[relative](std::size_t) { return relative; }, ambient});
  };
  const GrayBudget without = budget_of(gray, gray.noise()), with = of_shading(0.03, 0.0);
  EXPECT_EQ(without.shading_dn2, 0.0);
  EXPECT_NEAR(with.shading_dn2 / (0.03 * 0.03 * mean_square_signal(t, 1.5)), 1.0, 0.02);
  EXPECT_EQ(with.albedo_dn2, without.albedo_dn2);
  // more than there is in all cannot be part of it
  const GrayBudget too_much = of_shading(0.2, 0.0);
  EXPECT_EQ(too_much.shading_dn2, too_much.albedo_dn2);
}

// Normals shade the light of the projector alone: of s (E - a) a factor on E removes s (E - a).E / E.E, where
// E = L (1 + cos) over the steps has E.E = 1.5 L^2 and a.E = a L.
TEST(GrayBudget, NormalsDoNotShadeTheLightOfTheRoom) {
  constexpr double kShading = 0.03, kAmbient = 0.2;
  SidesTruth t = unclipped_truth(8);
  t.albedo_sigma = 0.05;
  const FittedGray gray(testing::make_sides(t));
  double sum = 0.0, n = 0.0;
  for (int y = 0; y < t.height; ++y)
    for (int x = 0; x < t.width; ++x)
      if (testing::is_lit(t, x, y)) {
        const double level = 0.5 * testing::weight_at(t, x, y);
        sum += std::pow(t.gain_dn * kShading * (1.5 * level - kAmbient), 2) / 1.5, n += 1.0;
      }
  const GrayBudget b = budget_of(gray, gray.noise(), {[](std::size_t) { return kShading; }, kAmbient});
  EXPECT_NEAR(b.shading_dn2 / (sum / n), 1.0, 0.02);
}

TEST(GrayBudget, ProjectorHarmonicIsFoundWithItsOrder) {
  SidesTruth t = unclipped_truth(8);
  t.second_harmonic = 0.04;
  const GrayBudget b = budget_of(t);
  const double truth = 0.5 * 0.04 * 0.04 * mean_square_signal(t, 1.0);
  EXPECT_NEAR(b.higher_orders_dn2 / truth, 1.0, 0.06);
  EXPECT_NEAR(b.harmonic_amplitude.at(2), 0.04, 0.002);
  EXPECT_LT(b.harmonic_amplitude.at(3), 0.003);
  EXPECT_NE(b.waveform.find("second harmonic 4 % of the first"), std::string::npos) << b.waveform;
  EXPECT_NEAR(b.rest_dn2 / b.total_dn2, 0.0, 0.03);
}

// Two percent of the first harmonic and what noise may add are not told.
TEST(GrayBudget, WhatIsNoHarmonicIsNotCalledOne) {
  SidesTruth t = unclipped_truth(3);
  t.albedo_sigma = 0.2;
  t.geometry_rad = 0.1;
  EXPECT_EQ(budget_of(t).waveform, "");
  t.second_harmonic = 0.01;
  EXPECT_EQ(budget_of(t).waveform, "");
  t.second_harmonic = 0.03;
  EXPECT_NE(budget_of(t).waveform, "");
}

TEST(GrayBudget, TheTwinsOwnHarmonicIsNoFaultOfIts) {
  SidesTruth t = unclipped_truth(8);
  t.second_harmonic = 0.04;
  testing::SyntheticSides scene = testing::make_sides(t);
  t.second_harmonic = 0.06;  // of the twin, so the residual has a harmonic
  t.black_level_dn = t.noise_dn = 0.0;
  t.round_real = false;
  scene.simulated.irradiance[0].images = testing::make_sides(t).real.images[0].images;
  std::vector<std::string> warnings;
  const auto pairs = pair_gray(scene.twin, scene.real, scene.simulated, {}, warnings);
  const GainFit fit = fit_gain(pairs.at(0), warnings);
  const auto b = gray_budget(pairs[0], fit, &scene.real.measurement->cameras[0],
                             &scene.simulated.measurement->cameras[0],
                             GrayNoise(pairs[0], &scene.real.measurement->cameras[0], {}));
  ASSERT_TRUE(b.has_value());
  EXPECT_NEAR(b->harmonic_amplitude.at(2), 0.02, 0.002);
  EXPECT_EQ(b->waveform, "");
}

TEST(GrayBudget, GeometryIsFound) {
  SidesTruth t = unclipped_truth(8);
  t.pitches_px = {13};
  t.geometry_rad = 0.05;
  const GrayBudget b = budget_of(t);
  const double truth = 0.5 * 0.05 * 0.05 * mean_square_signal(t, 1.0);
  EXPECT_NEAR(b.geometry_dn2 / truth, 1.0, 0.06);
  EXPECT_NEAR(b.rest_dn2 / b.total_dn2, 0.0, 0.03);
}

TEST(GrayBudget, AllAtOnceStillAddsUpAndLeavesLittle) {
  SidesTruth t = unclipped_truth(12);
  t.pitches_px = {60};
  t.albedo_sigma = 0.03;
  t.second_harmonic = 0.02;
  t.geometry_rad = 0.02;
  const GrayBudget b = budget_of(t);
  EXPECT_NEAR(sum_of_parts(b) / b.total_dn2, 1.0, 1e-9);
  EXPECT_GT(b.albedo_dn2, b.noise_dn2);
  EXPECT_NEAR(b.rest_dn2 / b.total_dn2, 0.0, 0.03);
}

TEST(GrayBudget, TheImagesOwnRedundancyBeatsWhatTheTwinBelieves) {
  SidesTruth t;
  t.steps = 8;
  SyntheticSides scene = testing::make_sides(t);
  scene.twin.cameras[0].sensor.electrons_per_dn = 2.0;  // a twin that believes in far more noise
  measure::DirectionDecode& d = scene.real.measurement->cameras[0].directions[0];
  d.noise_source = measure::NoiseSource::known;
  for (float& sigma : d.sigma_rad.data) sigma *= 5.0f;
  const GrayBudget b = budget_of(std::move(scene));
  EXPECT_NEAR(b.noise_dn2 / (t.noise_dn * t.noise_dn + 1.0 / 12.0), 1.0, 0.03);
  EXPECT_EQ(b.noise_source, "redundancy of the 8 phase steps of the real images");
}

// The variance of a scale from some 10^4 differences is known to a percent; 3 % are three standard errors.
TEST(GrayBudget, ThreeStepsTakeTheNoiseFromThePitches) {
  SidesTruth t;
  t.steps = 3;
  const GrayBudget b = budget_of(t);
  EXPECT_EQ(b.noise_source, "differences between the pitches' means of the real images");
  EXPECT_NEAR(b.noise_dn2 / (t.noise_dn * t.noise_dn + 1.0 / 12.0), 1.0, 0.03);
}

TEST(GrayBudget, WithoutADecodeTheNoiseIsTheSensorModels) {
  SyntheticSides scene = testing::make_sides({});
  EXPECT_EQ(GrayNoise(testing::gray_pair(scene), nullptr, {}).source(), "quantisation only");
  scene.twin.cameras[0].sensor.electrons_per_dn = 40.0;
  const FittedGray gray(std::move(scene));
  const GrayBudget b = budget_of(gray, GrayNoise(gray.pair, nullptr, {}));
  EXPECT_NEAR(b.noise_per_dn, 1.0 / 40.0, 1e-4);
  EXPECT_EQ(b.noise_source, "sensor model of the twin, not measured on these images");
}

}  // namespace
}  // namespace fringetwin::compare::gray_budget_test
