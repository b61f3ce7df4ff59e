// SPDX-License-Identifier: Apache-2.0
// Truth: the mean of a linear coordinate over pixels whose weight is an exponential, in closed form.
//
// | check            | tolerance | origin                                                              |
// |------------------|-----------|---------------------------------------------------------------------|
// | shift of a pixel | 2 %       | coth(g/2)/2 - 1/g = g/12 - g^3/720: 0.6 % at g = 0.6; float rounding |
#include "compare/phase/texture_shift.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace fringetwin::compare::texture_shift_test {
namespace {

constexpr int kWidth = 20, kHeight = 12;
constexpr double kPitch = 13.0, kSlopeX = 0.8, kSlopeY = -0.3;

/// A decode whose amplitude is 100 exp(g_x x + g_y y) DN.
measure::DirectionDecode decoded(double g_x, double g_y, double sigma_rad) {
  measure::DirectionDecode d;
  d.pitches_px = {kPitch};
  d.amplitude_dn = {ImageF(kWidth, kHeight)};
  d.sigma_rad = ImageF(kWidth, kHeight, static_cast<float>(sigma_rad));
  d.coordinate_px = ImageD(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      d.amplitude_dn[0](x, y) = static_cast<float>(100.0 * std::exp(g_x * x + g_y * y));
      d.coordinate_px(x, y) = 50.0 + kSlopeX * x + kSlopeY * y;
    }
  return d;
}

/// Returns how far the centroid of a pixel of weight exp(g x) lies beside its centre.
double centroid(double g) { return 0.5 / std::tanh(0.5 * g) - 1.0 / g; }

double shift_rad(const TextureShift& shift) { return static_cast<double>(shift.largest_rad(7, 5)); }

TEST(TextureShift, IsThatOfAnExponentialTexture) {
  const double per_px = 2.0 * std::numbers::pi / kPitch, g = 0.6;
  const auto plain = decoded(0.0, 0.0, 0.01);
  const double across = per_px * kSlopeX * centroid(g), down = per_px * -kSlopeY * centroid(g);
  EXPECT_NEAR(shift_rad(texture_shift(decoded(g, 0.0, 0.01), plain)), across, 0.02 * across);
  EXPECT_NEAR(shift_rad(texture_shift(decoded(0.0, -g, 0.01), plain)), down, 0.02 * down);
  EXPECT_NEAR(shift_rad(texture_shift(decoded(g, g, 0.01), plain)), across + down, 0.02 * (across + down));
}

TEST(TextureShift, IsNothingWhereTheTwinHasTheTextureOrNoiseMakesIt) {
  const auto textured = decoded(0.6, 0.0, 0.01);
  EXPECT_EQ(shift_rad(texture_shift(textured, textured)), 0.0);
  // sqrt(4) sigmas between two pixels of two sides, three of them: 6 * 0.11
  EXPECT_EQ(shift_rad(texture_shift(decoded(0.6, 0.0, 0.11), decoded(0.0, 0.0, 0.11))), 0.0);
  EXPECT_GT(shift_rad(texture_shift(decoded(0.6, 0.0, 0.09), decoded(0.0, 0.0, 0.09))), 0.0);
}

TEST(TextureShift, StaysWhereAFactorOfEachPixelMakesTheAmplitudesAgree) {
  const auto textured = decoded(0.6, 0.0, 0.01);
  PixelTexture texture;
  texture.factor = textured.amplitude_dn[0];
  const TextureShift of_factor = texture_shift(textured, textured, &texture),
                     without = texture_shift(textured, decoded(0.0, 0.0, 0.01));
  EXPECT_NEAR(shift_rad(of_factor), shift_rad(without), 1e-5 * shift_rad(without));
  const PixelTexture offset_alone;  // without a factor the amplitudes are what they were
  EXPECT_EQ(shift_rad(texture_shift(textured, textured, &offset_alone)), 0.0);
}

TEST(TextureShift, SeesOneEdgeFromBothSides) {
  auto real = decoded(0.0, 0.0, 0.01);
  const auto plain = real;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 8; x < kWidth; ++x) real.amplitude_dn[0](x, y) *= 0.35F;
  const TextureShift shift = texture_shift(real, plain);
  double sum = 0.0;
  for (int x = 1; x < kWidth - 1; ++x) {
    EXPECT_EQ(shift.largest_rad(x, 5) > 0.0F, x == 7 || x == 8) << x;
    sum += static_cast<double>(shift.signed_rad(x, 5));
  }
  // both towards the bright side, half of the step each
  EXPECT_NEAR(sum, 2.0 * std::numbers::pi / kPitch * kSlopeX * std::log(0.35) / 12.0, 1e-6);
}

TEST(TextureShift, UnknownNeighboursSayNothing) {
  auto real = decoded(0.6, 0.0, 0.01);
  real.amplitude_dn[0](6, 5) = real.amplitude_dn[0](8, 5) = std::nanf("");
  EXPECT_EQ(shift_rad(texture_shift(real, decoded(0.0, 0.0, 0.01))), 0.0);
}

}  // namespace
}  // namespace fringetwin::compare::texture_shift_test
