// SPDX-License-Identifier: Apache-2.0
// The response of a camera from series written by hand: levels by the formula, noise of block means and of
// the light of whole images from a fixed seed.
//
// | tolerance | unit    | origin                                                                      |
// |-----------|---------|-----------------------------------------------------------------------------|
// | 3 sigma   | of fit  | its own standard errors                                                     |
// | 0.8, 1.9  | of rms  | median said over what 80 draws have (known to 8 %): 1.2 to 1.55 are seen     |
// | 0.19      | DN      | held-out rms: 0.12 of noise 0.05 DN and image light 0.1 % (105 DN rms, bent) |
// |           |         | times sqrt(1 + 11/24) for 11 numbers fitted to 24 images; 3 sigma of 24      |
// |           |         | draws of light                                                              |
#include "calib/photometry/response_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <random>
#include <utility>
#include <vector>

#include "twin/base/statistics.hpp"

namespace fringetwin::calib::response_fit_test {
namespace {

constexpr double kBlack = 4.0, kPerMs = 50.0, kDelayMs = 0.05, kKnee = 120.0, kSlope = 0.8;

/// 48 exposures of so many blocks whose light differs by 10 %.
std::vector<ExposedBlocks> series(double slope, unsigned seed = 5, int blocks = 40) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<ExposedBlocks> out;
  for (int k = 0; k < 48; ++k) {
    ExposedBlocks image{0.3 + 0.08 * k, {}};
    const double light = 1.0 + 0.001 * normal(random);
    for (int b = 0; b < blocks; ++b) {
      const double x = light * (0.95 + 0.1 * b / (blocks - 1.0)) * kPerMs * (image.exposure_ms - kDelayMs);
      const double bent = x < kKnee ? x : kKnee + slope * (x - kKnee);
      image.level_dn.push_back(kBlack + bent + 0.05 * normal(random));
    }
    out.push_back(image);
  }
  return out;
}

TEST(ResponseFit, FindsThePlantedKnee) {
  const auto fit = fit_response(series(kSlope), kBlack, "test");
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->has_knee);
  EXPECT_NEAR(fit->knee_dn.value, kBlack + kKnee, 3.0 * fit->knee_dn.sigma);
  EXPECT_LT(fit->knee_dn.sigma, 5.0) << "a sigma that says nothing";
  EXPECT_NEAR(fit->knee_slope_ratio.value, kSlope, 3.0 * fit->knee_slope_ratio.sigma);
  EXPECT_NEAR(fit->dn_per_ms.value, kPerMs, 3.0 * fit->dn_per_ms.sigma);
  EXPECT_NEAR(fit->delay_ms.value, kDelayMs, 3.0 * fit->delay_ms.sigma);
  EXPECT_LT(fit->held_out_rms_dn, 0.19);
  EXPECT_LT(fit->held_out_rms_own_light_dn, fit->held_out_rms_dn);
}

// The jackknife leaves images out of pieces that hold three: where they weigh much its errors are wide, by
// half at most. The errors of knee and delay have been twice to three times as wide, when the corners moved
// along.
TEST(ResponseFit, ItsSigmasAreThoseOfManyDraws) {
  constexpr unsigned kDraws = 80;
  constexpr int kBlocks = 8;  // few, for time
  constexpr double kLeast = 0.8, kMost = 1.9;
  const std::pair<const char*, double> planted[] = {
      {"knee", kBlack + kKnee}, {"slope", kSlope}, {"DN per ms", kPerMs}, {"delay", kDelayMs}};
  double errors[std::size(planted)] = {};
  std::vector<double> said[std::size(planted)];
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    const auto fit = fit_response(series(kSlope, 1000 + seed, kBlocks), kBlack, "test");
    ASSERT_TRUE(fit && fit->has_knee) << seed;
    const Estimate found[] = {fit->knee_dn, fit->knee_slope_ratio, fit->dn_per_ms, fit->delay_ms};
    for (std::size_t k = 0; k < std::size(planted); ++k) {
      errors[k] += std::pow(found[k].value - planted[k].second, 2) / kDraws;
      said[k].push_back(found[k].sigma);
    }
  }
  for (std::size_t k = 0; k < std::size(planted); ++k) {
    const double ratio = upper_median(said[k]) / std::sqrt(errors[k]);
    EXPECT_GT(ratio, kLeast) << planted[k].first;
    EXPECT_LT(ratio, kMost) << planted[k].first;
  }
}

TEST(ResponseFit, FindsNoKneeInAStraightLine) {
  const auto fit = fit_response(series(1.0), kBlack, "test");
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->has_knee);
}

TEST(ResponseFit, FewExposuresTellNothing) {
  std::vector<ExposedBlocks> few = series(kSlope);
  few.resize(15);
  EXPECT_FALSE(fit_response(few, kBlack, "test"));
}

}  // namespace
}  // namespace fringetwin::calib::response_fit_test
