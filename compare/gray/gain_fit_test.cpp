// SPDX-License-Identifier: Apache-2.0
// Truth: synthetic images with known gain and black level (tests/support/compare/synthetic_sides.hpp).
// | check                              | tolerance        | origin                                        |
// |------------------------------------|------------------|-----------------------------------------------|
// | gain, black with Gaussian noise    | 3 sigma          | reported standard error, checked by coverage  |
// | sigma against sigma/sqrt(n var E)  | 15 %             | 30 blocks give the sandwich about 13 % scatter |
// | 5 % outliers at +80 DN             | 0.2 DN, 0.2 %    | Huber's bias k s eps/(1-eps) = 0.11 DN        |
// | noise-free                         | 5e-4 relative    | rounding to 1 DN over n values                |
#include "compare/gray/gain_fit.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>

#include "compare/gray/gray_rows.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gain_fit_test {
namespace {

using testing::FittedGray;
using testing::SidesTruth;
using testing::SyntheticSides;

void expect_recovered(const GainRow& row, const SidesTruth& t, double sigmas = 3.0) {
  ASSERT_TRUE(row.usable);
  EXPECT_NEAR(row.gain_dn, t.gain_dn, sigmas * row.gain_sigma_dn);
  EXPECT_NEAR(row.black_level_dn, t.black_level_dn, sigmas * row.black_level_sigma_dn);
}

TEST(GainFit, RecoversGainAndBlackWithinTheirSigma) {
  const SidesTruth t;
  const FittedGray f(testing::make_sides(t));
  const GainRow& row = f.fit.row;
  expect_recovered(row, t);
  EXPECT_LT(row.gain_sigma_dn, 1e-3 * row.gain_dn);
  EXPECT_NEAR(row.rms_after_dn, std::sqrt(t.noise_dn * t.noise_dn + 1.0 / 12.0), 0.02);
  EXPECT_GT(row.rms_before_dn, 5.0 * row.rms_after_dn);  // the twin's gain is 16 % off
  EXPECT_GT(row.r2, 0.998);
  EXPECT_NEAR(row.sigma_inflation, 1.0, 0.4);  // independent noise
}

TEST(GainFit, SigmaAgreesWithTheClosedFormForIndependentNoise) {
  const SidesTruth t;
  const FittedGray f(testing::make_sides(t));
  double n = 0, e1 = 0, e2 = 0;
  for (int image : f.pair.gain_images) {
    const ImageF d = gray_difference(f.pair, f.fit, image);
    for (std::size_t i = 0; i < d.size(); ++i)
      if (!std::isnan(d.data[i])) {
        const double e = f.pair.irradiance_at(image, i);
        n += 1, e1 += e, e2 += e * e;
      }
  }
  EXPECT_EQ(static_cast<std::uint64_t>(n), f.fit.row.n);
  const double variance_e = e2 / n - e1 / n * (e1 / n);
  // Huber's estimator with k = 1.345 has 95 % of the efficiency of least squares
  const double expected = std::sqrt((t.noise_dn * t.noise_dn + 1.0 / 12.0) / (n * variance_e) / 0.95);
  EXPECT_NEAR(f.fit.row.gain_sigma_dn / expected, 1.0, 0.25);
}

TEST(GainFit, SaturatedImagesDoNotPullTheGainDown) {
  SidesTruth t;
  t.gain_dn = 34.0;  // 340 DN at the brightest: a quarter of the values clip at 255
  t.black_level_dn = 12.0;
  t.noise_dn = 2.0;
  const FittedGray f(testing::make_sides(t));
  expect_recovered(f.fit.row, t, 3.5);
  EXPECT_LT(f.fit.row.high_dn, 254.0);
}

TEST(GainFit, OutliersMoveItLittle) {
  SidesTruth t;
  t.outlier_fraction = 0.05;
  t.outlier_dn = 80.0;
  t.gain_dn = 15.0;  // keeps most outliers below saturation
  const FittedGray f(testing::make_sides(t));
  EXPECT_NEAR(f.fit.row.gain_dn / t.gain_dn, 1.0, 0.002);
  EXPECT_NEAR(f.fit.row.black_level_dn, t.black_level_dn, 0.2);
  EXPECT_GT(f.fit.row.outlier_fraction, 0.05);
}

TEST(GainFit, NoiseFreeImagesLeaveTheRoundingOnly) {
  SidesTruth t;
  t.noise_dn = 0.0;
  const FittedGray f(testing::make_sides(t));
  EXPECT_NEAR(f.fit.row.gain_dn / t.gain_dn, 1.0, 5e-4);
  EXPECT_NEAR(f.fit.row.rms_after_dn, std::sqrt(1.0 / 12.0), 0.01);
  EXPECT_GT(f.fit.row.gain_sigma_dn, 0.0);
}

TEST(GainFit, WorksFromSimulatedGrayValuesAlone) {
  SidesTruth t;
  SyntheticSides scene = testing::make_sides(t);
  scene.simulated.irradiance.clear();
  const FittedGray f(std::move(scene));
  EXPECT_TRUE(f.pair.from_dn);
  expect_recovered(f.fit.row, t, 4.0);
}

TEST(GainFit, TwelveBitAndRadianceImages) {
  SidesTruth t = testing::misjudged_truth();
  expect_recovered(FittedGray(testing::make_sides(t)).fit.row, t);
  t.round_real = false;
  SyntheticSides scene = testing::make_sides(t);
  for (CameraImages& images : scene.real.images) images.radiance = true;
  const GainRow row = FittedGray(std::move(scene)).fit.row;
  expect_recovered(row, t);
  EXPECT_TRUE(std::isnan(row.rms_before_dn));  // the twin's gray values against irradiance say nothing
}

TEST(GainFit, GrayCodeOfAnotherExposureIsLeftOut) {
  SidesTruth t;
  t.pitches_px = {16};
  t.gray_bits = 4;
  SyntheticSides scene = testing::make_sides(t);
  const FittedGray same(scene);
  EXPECT_EQ(same.pair.images.size(), 8u);
  EXPECT_EQ(same.pair.gain_images.size(), 4u);
  scene.real.images[0].gray_code_exposure = std::nan("");
  const FittedGray different(scene);
  EXPECT_EQ(different.pair.images.size(), 4u);
  ASSERT_FALSE(different.warnings.empty());
  EXPECT_NE(different.warnings[0].find("another exposure"), std::string::npos);
  scene.real.images[0].gray_code_exposure = 1.0;
  EXPECT_EQ(FittedGray(scene).pair.images.size(), 8u);
}

TEST(GainFit, UsesOnlyTheStepsAsked) {
  SidesTruth t;
  t.steps = 6;
  CompareOptions options;
  options.use_steps = {1, 3, 5};
  const SyntheticSides scene = testing::make_sides(t);
  std::vector<std::string> warnings;
  EXPECT_EQ(pair_gray(scene.twin, scene.real, scene.simulated, options, warnings).at(0).gain_images.size(),
            9u);
}

TEST(GainFit, DoesNotDependOnTheNumberOfThreads) {
  const SyntheticSides scene = testing::make_sides({});
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const GainRow one = FittedGray(scene).fit.row;
  omp_set_num_threads(3);
  const GainRow three = FittedGray(scene).fit.row;
  omp_set_num_threads(before);
  EXPECT_EQ(one.gain_dn, three.gain_dn);
  EXPECT_EQ(one.gain_sigma_dn, three.gain_sigma_dn);
  EXPECT_EQ(one.rms_after_dn, three.rms_after_dn);
}

TEST(GainFit, TooFewPixelsIsAWarningAndNoNumber) {
  SyntheticSides scene = testing::make_sides({});
  scene.real.measurement->cameras[0].flags = ImageU8(192, 160, measure::kSaturated);
  const FittedGray f(std::move(scene));
  EXPECT_FALSE(f.fit.row.usable);
  EXPECT_TRUE(std::isnan(f.fit.row.gain_dn));
  EXPECT_EQ(f.warnings.size(), 1u);
}

TEST(GainFit, ConstantIrradianceHasNoGain) {
  SyntheticSides scene = testing::make_sides({});
  for (GrayImage& image : scene.simulated.irradiance[0].images) std::ranges::fill(image.as_floats(), 5.0f);
  EXPECT_FALSE(FittedGray(std::move(scene)).fit.row.usable);
}

TEST(GrayRows, MatchABruteForcePercentile) {
  const FittedGray f(testing::make_sides({}));
  const std::vector<GrayRow> rows = gray_rows(f.sides.twin, f.pair, f.fit);
  ASSERT_EQ(rows.size(), 12u);
  const ImageF d = gray_difference(f.pair, f.fit, 0);
  std::vector<double> magnitude;
  double sum = 0, sum2 = 0;
  for (float v : d.data)
    if (!std::isnan(v)) {
      const double value = static_cast<double>(v);
      magnitude.push_back(std::abs(value)), sum += value, sum2 += value * value;
    }
  std::sort(magnitude.begin(), magnitude.end());
  const double n = static_cast<double>(magnitude.size());
  EXPECT_EQ(rows[0].n, magnitude.size());
  EXPECT_NEAR(rows[0].mean_dn, sum / n, 1e-9);
  EXPECT_NEAR(rows[0].rms_dn, std::sqrt(sum2 / n), 1e-9);
  EXPECT_NEAR(rows[0].p99_dn, magnitude[static_cast<std::size_t>(0.99 * n)], 0.02 * rows[0].rms_dn);
}

// As a camera of 8 bit shows them: between 0 and 255 DN.
TEST(GrayRows, PredictedImagesStayInTheRangeOfTheCamera) {
  FittedGray f(testing::make_sides({}));
  f.fit.row.gain_dn = 1000.0, f.fit.row.black_level_dn = -5.0;
  const ImageF predicted = predicted_gray(f.pair, f.fit, 0);
  EXPECT_EQ(*std::ranges::max_element(predicted.data), 255.0F);
  EXPECT_EQ(*std::ranges::min_element(predicted.data), 0.0F);
}

}  // namespace
}  // namespace fringetwin::compare::gain_fit_test
