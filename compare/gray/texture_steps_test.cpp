// SPDX-License-Identifier: Apache-2.0
// Truth: the mean over a pixel of a fringe times a reflectivity, by a sum over its points; the factor that a
// pixel's images have in common is the best one by least squares.
//
// | check                  | tolerance    | origin                                                          |
// |------------------------|--------------|-----------------------------------------------------------------|
// | steep, and is not      | factor of 2  | each side of 0.1 of the noise: the gray value's error is one of |
// |                        |              | dln(w)/dx as it is over the neighbours (an edge: up to twice)   |
#include "compare/gray/texture_steps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

namespace fringetwin::compare::texture_steps_test {
namespace {

constexpr int kWidth = 41, kHeight = 7, kPoints = 200, kCentre = 20;
constexpr double kGain = 800.0, kBlack = 60.0, kRadPerPx = 0.5;

/// Four phase steps of a plane that has a reflectivity of x, which the twin does not know.
class TexturedPlane {
 public:
  TexturedPlane(const std::function<double(double)>& reflectivity, double read_noise_dn) {
    camera_.sensor.read_noise_dn = read_noise_dn;
    camera_.sensor.bit_depth = 12;
    real_.bit_depth = 12;
    irradiance_.radiance = true;
    for (int k = 0; k < 4; ++k) {
      ImageF real(kWidth, kHeight), simulated(kWidth, kHeight);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          double sum = 0.0, plain = 0.0;
          for (int i = 0; i < kPoints; ++i) {
            const double at = x - 0.5 + (i + 0.5) / kPoints,
                         e = 1.0 + 0.8 * std::cos(kRadPerPx * at + k * std::numbers::pi / 2.0);
            sum += reflectivity(at) * e / kPoints;
            plain += e / kPoints;
          }
          real(x, y) = static_cast<float>(kGain * sum + kBlack);
          simulated(x, y) = static_cast<float>(plain);
        }
      real_.images.push_back(std::move(real));
      irradiance_.images.push_back(std::move(simulated));
      pair_.gain_images.push_back(k);
    }
    pair_.camera = &camera_;
    pair_.real = &real_;
    pair_.irradiance = &irradiance_;
    pair_.mask = ImageU8(kWidth, kHeight, 1);
    usable_.gain_dn = kGain;
    usable_.black_level_dn = kBlack;
  }
  TexturedPlane(const TexturedPlane&) = delete;
  TexturedPlane& operator=(const TexturedPlane&) = delete;

  bool is_steep(int x, int y = kHeight / 2) const {
    const GrayNoise noise(pair_, nullptr, {});
    return TextureSteps(pair_, usable_, noise).is_steep(static_cast<std::size_t>(y * kWidth + x));
  }

  /// Returns the largest gray value that the best factor of this pixel leaves.
  double left_by_a_factor_dn(int x) const {
    double both = 0.0, own = 0.0, most = 0.0;
    const auto real_dn = [&](int k) {
      return static_cast<double>(real_.images[static_cast<std::size_t>(k)](x, kHeight / 2)) - kBlack;
    };
    const auto predicted_dn = [&](int k) {
      return kGain * static_cast<double>(irradiance_.images[static_cast<std::size_t>(k)](x, kHeight / 2));
    };
    for (int k = 0; k < 4; ++k)
      both += real_dn(k) * predicted_dn(k), own += predicted_dn(k) * predicted_dn(k);
    for (int k = 0; k < 4; ++k) most = std::max(most, std::abs(real_dn(k) - both / own * predicted_dn(k)));
    return most;
  }

 private:
  Camera camera_{"left", Lens("LENSMODEL_PINHOLE", {400.0, 400.0, 20.0, 3.0}, {kWidth, kHeight}, "test"),
                 Pose{}, Sensor{}, std::nullopt};
  CameraImages real_, irradiance_;
  GrayPair pair_;
  UsableRange usable_;
};

double ramp(double slope, double x) { return std::exp(slope * (x - kCentre)); }
double edge(double x) { return x < kCentre + 0.1 ? 1.0 : 0.35; }

TEST(TextureSteps, ASlopeIsSteepWhenItsGrayValuesShowIt) {
  for (const double slope : {0.02, 0.1, 0.3}) {
    const auto reflectivity = [slope](double x) { return ramp(slope, x); };
    const double wrong_dn = TexturedPlane(reflectivity, 1.0).left_by_a_factor_dn(kCentre);
    EXPECT_TRUE(TexturedPlane(reflectivity, wrong_dn / 0.2).is_steep(kCentre)) << slope;
    EXPECT_FALSE(TexturedPlane(reflectivity, wrong_dn / 0.05).is_steep(kCentre)) << slope;
  }
}

TEST(TextureSteps, AnEdgeIsSteepAndNothingBesideIt) {
  const TexturedPlane plane(edge, 4.0);
  ASSERT_GT(plane.left_by_a_factor_dn(kCentre), 4.0);
  EXPECT_TRUE(plane.is_steep(kCentre));
  for (const int x : {kCentre - 2, kCentre + 2}) {
    EXPECT_LT(plane.left_by_a_factor_dn(x), 0.01);
    EXPECT_FALSE(plane.is_steep(x)) << x;
  }
}

TEST(TextureSteps, WhatNoiseMayMakeIsNone) {
  // ln w differs by 0.1; of 4 values of about 800 DN each, 3 sigmas of the difference are 0.1 at 37 DN
  const auto reflectivity = [](double x) { return ramp(0.1, x); };
  EXPECT_TRUE(TexturedPlane(reflectivity, 20.0).is_steep(kCentre));
  EXPECT_FALSE(TexturedPlane(reflectivity, 60.0).is_steep(kCentre));
}

TEST(TextureSteps, TheBorderAndDarkNeighboursAreNone) {
  const TexturedPlane plane(edge, 4.0);
  for (const int x : {0, kWidth - 1}) EXPECT_FALSE(plane.is_steep(x));
  EXPECT_FALSE(plane.is_steep(kCentre, 0));
  const TexturedPlane dark([](double) { return 0.0; }, 4.0);
  EXPECT_FALSE(dark.is_steep(kCentre));
}

}  // namespace
}  // namespace fringetwin::compare::texture_steps_test
