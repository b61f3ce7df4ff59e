// SPDX-License-Identifier: Apache-2.0
// Where the values of made-up light stand: level, phase, pixel and image are known by formula.
//
// | check        | tolerance | origin                                          |
// |--------------|-----------|-------------------------------------------------|
// | level, rest  | 1e-3      | single precision of 200 DN, a few roundings     |
// | phase        | 1e-5 rad  | single precision of sums of five values         |
#include "compare/pattern/what_is_left.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace fringetwin::compare::what_is_left_test {
namespace {

constexpr double kPi = std::numbers::pi, kGain = 20.0, kBlack = 15.0;
constexpr int kSteps = 5;

Twin twin_of_five_steps() {
  Twin twin;
  twin.cameras.push_back({"left", Lens("LENSMODEL_PINHOLE", {900, 900, 31, 23}, {64, 48}, "test"), Pose{},
                          Sensor{}, std::nullopt});
  twin.fringes.directions = {{Axis::x, {13, 14}, {0, 0}, {}}};
  twin.fringes.steps = kSteps;
  return twin;
}

double phase_of(std::size_t cell, int image) {
  return 0.7 * static_cast<double>(cell) + 0.3 * (image / kSteps) + 2.0 * kPi * (image % kSteps) / kSteps;
}

/// Two pixels of every third, images in another order and two of the second pitch alone: these have no phase.
/// Every value is `rest_dn` above what is predicted.
struct Light {
  GridSamples samples;
  std::vector<float> irradiance;
};
Light light(double rest_dn) {
  Light out;
  GridSamples& s = out.samples;
  s.grid = {3, 1, 1, 21, 16};
  s.images = {2, 0, 1, 3, 4, 6, 5};
  s.cell = {4, 30};
  s.gain_dn = kGain;
  s.black_level_dn = kBlack;
  for (const std::size_t cell : s.cell)
    for (const int image : s.images) {
      out.irradiance.push_back(static_cast<float>(4.0 + 3.0 * std::cos(phase_of(cell, image))));
      s.real_dn.push_back(
          static_cast<float>(kGain * static_cast<double>(out.irradiance.back()) + kBlack + rest_dn));
      s.weight.push_back(0.5F);
    }
  s.weight[3] = 0.0F;
  return out;
}

TEST(WhatIsLeft, ValuesStandWhereTheyAre) {
  const Light made = light(0.8);
  const LeftOver left =
      what_is_left(made.samples, made.irradiance, twin_of_five_steps(), 3.0, FreePerPixel::nothing);
  EXPECT_EQ(left.camera, "left");
  EXPECT_EQ(left.middle_x_px, 31.5);
  EXPECT_EQ(left.middle_y_px, 23.5);
  ASSERT_EQ(left.values.size(), 13u);  // one has no weight
  for (std::size_t i = 0; i < left.values.size(); ++i) {
    const LeftValue& v = left.values[i];
    const std::size_t cell = i < 6 ? 4 : 30;
    EXPECT_EQ(v.x_px, 1.0F + 3.0F * static_cast<float>(cell % 21));
    EXPECT_EQ(v.y_px, 1.0F + 3.0F * static_cast<float>(cell / 21));
    EXPECT_NEAR(v.sigmas, 0.5 * 0.8, 1e-3);
    const double phase = phase_of(cell, v.image);
    EXPECT_NEAR(v.level_dn, kBlack + kGain * (4.0 + 3.0 * std::cos(phase)), 1e-3);
    if (v.image < kSteps) {
      EXPECT_NEAR(std::remainder(static_cast<double>(v.phase_rad) - phase, 2.0 * kPi), 0.0, 1e-5);
    } else {
      EXPECT_TRUE(std::isnan(v.phase_rad));
    }
  }
}

TEST(WhatIsLeft, OutliersCountAsTheirWeightsHaveIt) {
  const Light made = light(20.0);  // 10 standard deviations: 3 * 10 of chi2
  for (const LeftValue& v :
       what_is_left(made.samples, made.irradiance, twin_of_five_steps(), 3.0, FreePerPixel::nothing).values)
    EXPECT_NEAR(v.sigmas, std::sqrt(30.0), 1e-3);
}

TEST(WhatIsLeft, AFactorOfThePixelsOwnTakesItsPart) {
  Light made = light(0.0);
  for (std::size_t i = 0; i < made.irradiance.size(); ++i)
    made.samples.real_dn[i] += i < 7 ? 2.0F * made.irradiance[i] : -made.irradiance[i];
  for (const LeftValue& v :
       what_is_left(made.samples, made.irradiance, twin_of_five_steps(), 30.0, FreePerPixel::factor).values)
    EXPECT_NEAR(v.sigmas, 0.0, 1e-3);
}

// Of a value without weight nothing is asked: a pixel's own line is that of the others.
TEST(WhatIsLeft, AFactorAndAnOffsetOfThePixelsOwnTakeTheirPart) {
  Light made = light(0.0);
  for (std::size_t i = 0; i < made.irradiance.size(); ++i)
    made.samples.real_dn[i] += i < 7 ? 2.0F * made.irradiance[i] + 5.0F : -made.irradiance[i] - 3.0F;
  const auto most_left = [&](FreePerPixel own) {
    double most = 0.0;
    for (const LeftValue& v :
         what_is_left(made.samples, made.irradiance, twin_of_five_steps(), 30.0, own).values)
      most = std::max(most, std::abs(static_cast<double>(v.sigmas)));
    return most;
  };
  EXPECT_NEAR(most_left(FreePerPixel::factor_and_offset), 0.0, 1e-3);
  EXPECT_GT(most_left(FreePerPixel::factor), 0.5);
  EXPECT_GT(most_left(FreePerPixel::offset), 0.5);
}

}  // namespace
}  // namespace fringetwin::compare::what_is_left_test
