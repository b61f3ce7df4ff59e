// SPDX-License-Identifier: Apache-2.0
// Noise of right twins: what the real images tell of it against the residuals of the gain fit.
//
// | check                         | tolerance | origin                                                  |
// |-------------------------------|-----------|---------------------------------------------------------|
// | noise chi2 of right twins     | 0.02      | 3 standard errors, sqrt(2 / 50,000)                     |
// | albedo / total, N > 4         | 0.005     | 3 standard errors; 0.013 ... 0.04 with the mean's noise |
// | albedo / total, N = 3 and 4   | 0.015     | the slope is known to 10 %; 0.04 ... 0.07 without it    |
#include "compare/gray/gray_noise.hpp"

#include <gtest/gtest.h>

#include "compare/gray/gray_budget.hpp"
#include "compare/gray/interior_mask.hpp"
#include "compare/verdict/explained.hpp"
#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gray_noise_test {
namespace {

using testing::FittedGray;
using testing::SidesTruth;

SidesTruth right_twin(int steps, int bits, double contrast) {
  SidesTruth t;
  if (bits == 12) t = testing::deep_truth(400.0);
  if (bits == 8) t.black_level_dn = 8.0, t.noise_dn = 0.6;
  t.electrons_per_dn = bits == 12 ? 2.5 : 40.0;
  t.twin_gain_dn = t.gain_dn;
  t.twin_black_level_dn = t.black_level_dn;
  t.width = steps <= 5 ? 384 : 192;
  t.height = steps <= 5 ? 320 : 160;
  t.steps = steps;
  t.contrast = contrast;
  return t;
}

ExplainedRow explained(const FittedGray& gray, const OwnKinds& own = {}) {
  const measure::CameraDecode *real = gray.real_decode(), *simulated = gray.simulated_decode();
  return explain_gray(gray.pair, gray.fit, gray.noise(), interior_mask(gray.pair.mask, real, simulated),
                      simulated, {}, {}, {}, {.kinds = own, .images = gray.pair.images});
}

void expect_right(int steps, int bits, double contrast) {
  const ::testing::ScopedTrace trace(
      __FILE__, __LINE__, ::testing::Message() << steps << " steps, " << bits << " bit, " << contrast);
  const FittedGray gray(testing::make_sides(right_twin(steps, bits, contrast)), testing::Margins::noise);
  const GrayNoise noise = gray.noise();
  EXPECT_TRUE(noise.measured());
  EXPECT_GE(noise.known_to(), kMeasuredKnownTo);
  EXPECT_LT(noise.known_to(), 0.015);
  EXPECT_NEAR(explained(gray).noise_chi2, 1.0, 0.02);
  const auto budget = gray_budget(gray.pair, gray.fit, gray.real_decode(), gray.simulated_decode(), noise);
  ASSERT_TRUE(budget);
  EXPECT_NEAR(budget->albedo_dn2 / budget->total_dn2, 0.0, steps <= 4 ? 0.015 : 0.005);
}

TEST(GrayNoise, OfRightTwinsIsWhatTheirResidualsShow) {
  // more than three steps at other depths and contrasts: measure/decode/phase_noise_test.cpp
  for (const int bits : {8, 12})
    for (const double contrast : {0.45, 0.5}) expect_right(3, bits, contrast);
  expect_right(4, 12, 0.5);
  expect_right(7, 8, 0.45);
}

TEST(GrayNoise, AFactorPerPixelTakesMoreThanOneValuesNoise) {
  testing::SyntheticSides sides = testing::make_sides(right_twin(3, 12, 0.5));
  const std::vector<GrayImage>& real = sides.real.images[0].images;
  std::vector<GrayImage>& light = sides.simulated.irradiance[0].images;
  for (std::size_t i = 0; i < light[0].size(); ++i) {
    double ye = 0.0, ee = 0.0;
    for (std::size_t k = 0; k < light.size(); ++k) {
      const auto e = static_cast<double>(light[k][i]);
      ye += (static_cast<double>(real[k][i]) - 400.0) * e, ee += e * e;
    }
    if (!(ee > 0.0)) continue;
    for (GrayImage& image : light) image.as_floats()[i] *= static_cast<float>(ye / (200.0 * ee));
  }
  const FittedGray gray(std::move(sides), testing::Margins::noise);
  const ExplainedRow row = explained(gray, {.factor = true});
  EXPECT_LT(row.noise_chi2, 0.86);  // 8/9 were all values as noisy
  EXPECT_NEAR(row.chi2_least / (1.0 - allowed_for(static_cast<double>(row.n), gray.noise().known_to())),
              row.noise_chi2, 0.02);
}

}  // namespace
}  // namespace fringetwin::compare::gray_noise_test
