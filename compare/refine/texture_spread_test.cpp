// SPDX-License-Identifier: Apache-2.0
// Truth: gray values that are sums over a fine grid of texture times fringe under a Gaussian pixel, whose
// second moment is planted.
//
// | check            | tolerance                | origin                                                 |
// |------------------|--------------------------|--------------------------------------------------------|
// | spread, no noise | 2 %                      | third derivatives of a texture of 18 px period under   |
// |                  |                          | 0.8 px: (2 pi/18)^2 (0.8^2 + 1/6 of the differences)/2 |
// | spread, noise    | 4 standard errors or 2 % | drawn noise; the line above                            |
#include "compare/refine/texture_spread.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace fringetwin::compare::texture_spread_test {
namespace {

constexpr int kWidth = 160, kHeight = 120, kSteps = 8;
constexpr double kPeriod = 24.0, kGain = 50.0, kBlack = 5.0;

double texture_at(double x, double y) {
  const double turn = 2.0 * std::numbers::pi / 18.0;
  return 0.6 * (1.0 + 0.4 * std::sin(turn * x) * std::cos(turn * 0.8 * y));
}
double light_at(double x, double y, int step) {
  return 2.0 + 1.6 * std::cos(2.0 * std::numbers::pi * ((x + 0.2 * y) / kPeriod + step / double{kSteps}));
}

/// What a camera of Gaussian pixels sees of textured and plain surface.
struct Scene {
  CameraImages real;
  std::vector<GrayImage> light;
  PixelTexture texture;
};

Scene scene(double spread_px, double noise_dn) {
  Scene s;
  s.real.camera = "camera";
  s.real.bit_depth = 8;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, noise_dn > 0.0 ? noise_dn : 1.0);
  std::vector<std::pair<double, double>> nodes;  // offset, weight: 13 along each axis, out to 3 sigma
  double sum = 0.0, moment = 0.0;
  for (int k = -6; k <= 6; ++k) nodes.emplace_back(0.5 * k * spread_px, std::exp(-0.125 * k * k));
  for (const auto& [at, weight] : nodes) sum += weight, moment += weight * at * at;
  const double stretch = spread_px / std::sqrt(moment / sum);
  for (int k = 0; k < kSteps; ++k) {
    ImageF gray(kWidth, kHeight), plain(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        double both = 0.0, alone = 0.0;
        for (const auto& [dx, wx] : nodes)
          for (const auto& [dy, wy] : nodes) {
            const double e = light_at(x + stretch * dx, y + stretch * dy, k), w = wx * wy / sum / sum;
            both += w * e * texture_at(x + stretch * dx, y + stretch * dy), alone += w * e;
          }
        gray(x, y) = static_cast<float>(kBlack + kGain * both + (noise_dn > 0.0 ? noise(random) : 0.0));
        plain(x, y) = static_cast<float>(alone);
      }
    s.real.images.push_back(std::move(gray));
    s.light.push_back(std::move(plain));
  }
  return s;
}

std::optional<TextureSpread> fitted(Scene& s) {
  const OwnKinds kinds{.factor = true, .offset = true};
  std::vector<int> images(kSteps);
  for (int k = 0; k < kSteps; ++k) images[static_cast<std::size_t>(k)] = k;
  const std::vector<double> exposures;
  const GrayOverLight values(s.real, s.light, images, exposures, {kGain, kBlack});
  s.texture.factor = ImageF(kWidth, kHeight);
  for (std::size_t i = 0; i < s.texture.factor.size(); ++i) {
    OwnLightSums sums;
    for (const std::size_t k : values.images()) sums.add(values.light_at(k, i), values.gray_at(k, i));
    s.texture.factor.data[i] = static_cast<float>(sums.line(kinds).factor);
  }
  return fit_texture_spread(kinds, values, s.texture);
}

TEST(TextureSpread, IsThatOfThePixels) {
  for (const double spread_px : {0.3, 0.8}) {
    Scene s = scene(spread_px, 0.0);
    const auto found = fitted(s);
    ASSERT_TRUE(found.has_value()) << spread_px;
    EXPECT_NEAR(found->spread_px, spread_px, 0.02 * spread_px);
  }
}

TEST(TextureSpread, NoiseOfTheFactorsMovesItByItsStandardErrorOnly) {
  for (const double noise_dn : {0.5, 2.0}) {  // 2 DN: the slopes of the factors have as much noise as texture
    Scene s = scene(0.8, noise_dn);
    const auto found = fitted(s);
    ASSERT_TRUE(found.has_value()) << noise_dn;
    EXPECT_LT(found->sigma_px, 0.05);
    EXPECT_NEAR(found->spread_px, 0.8, std::hypot(4.0 * found->sigma_px, 0.016)) << found->sigma_px;
  }
}

// One pixel in a hundred shows something else: its fringes lie 0.3 rad further.
TEST(TextureSpread, PixelsOfAnotherKindAreLeftOut) {
  Scene s = scene(0.8, 0.5);
  for (std::size_t i = 0; i < s.light[0].size(); i += 97)
    for (int k = 0; k < kSteps; ++k) {
      const double x = static_cast<double>(i % kWidth), y = static_cast<double>(i / kWidth);
      const double moved = light_at(x + 0.3 * kPeriod / (2.0 * std::numbers::pi), y, k);
      s.real.images[k].as_floats()[i] = static_cast<float>(kBlack + kGain * moved * texture_at(x, y));
    }
  const auto found = fitted(s);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->spread_px, 0.8, std::hypot(4.0 * found->sigma_px, 0.016)) << found->sigma_px;
}

TEST(TextureSpread, IsNotToldWithoutATexture) {
  Scene s = scene(0.8, 1.0);
  for (std::size_t k = 0; k < kSteps; ++k)  // the same fringes on plain paper
    for (std::size_t i = 0; i < s.light[k].size(); ++i)
      s.real.images[k].as_floats()[i] = static_cast<float>(kBlack + 0.5 * kGain * s.light[k][i]) +
                                        0.5F * static_cast<float>((i * 7919 + k * 104729) % 13) / 6.0F;
  EXPECT_FALSE(fitted(s).has_value());
}

}  // namespace
}  // namespace fringetwin::compare::texture_spread_test
