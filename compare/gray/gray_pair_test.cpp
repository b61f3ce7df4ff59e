// SPDX-License-Identifier: Apache-2.0
// | check                  | tolerance  | origin                                                   |
// |------------------------|------------|----------------------------------------------------------|
// | straightened value     | 0.55 DN    | rounding of half a gray value over the least slope 0.95, |
// |                        |            | a factor of 0.96                                         |
// | ranges, clipped values | 0          | bounds                                                   |
#include "compare/gray/gray_pair.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gray_pair_test {
namespace {

// 8 bit: at least 2 DN, at most a quarter of the 255 DN.
TEST(GrayPair, EachEndOfTheRangeHasItsOwnMargin) {
  const testing::SyntheticSides sides = testing::make_sides({});
  const GrayPair pair = testing::gray_pair(sides);
  const UsableRange u = usable_range(pair, 17.0, 4.0, {.low_dn = 5.0, .high_dn = 9.0});
  EXPECT_EQ(u.low_dn, 5.0);
  EXPECT_EQ(u.high_dn, 246.0);
  EXPECT_EQ(u.gain_dn, 17.0);
  EXPECT_EQ(u.black_level_dn, 4.0);
  const UsableRange narrow = usable_range(pair, 17.0, 4.0, {.low_dn = 0.5, .high_dn = 300.0});
  EXPECT_EQ(narrow.low_dn, 2.0);
  EXPECT_EQ(narrow.high_dn, 255.0 - 0.25 * 255.0);
}

/// A sensor whose pixels differ by 1 % in gain and by 1 DN in black level, with a knee; and what it makes of
/// light, written out here once more.
struct UnevenSensor {
  static constexpr int kWidth = 100, kHeight = 80;
  static constexpr double kBlackDn = 20.0, kKneeDn = 120.0, kSlope = 0.95;
  static constexpr std::size_t kHot = 17;
  Sensor sensor;
  ImageF factor{kWidth, kHeight}, offset_dn{kWidth, kHeight};

  UnevenSensor() {
    sensor.black_level_dn = kBlackDn;
    sensor.response = knee_response(kKneeDn, kSlope);
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    for (std::size_t i = 0; i < factor.size(); ++i) {
      factor.data[i] = 1.0F + 0.01F * normal(random);
      offset_dn.data[i] = normal(random);
    }
    offset_dn.data[kHot] = 90.0F;
    sensor.prnu.values = std::make_shared<const ImageF>(factor);
    sensor.dsnu.values = std::make_shared<const ImageF>(offset_dn);
  }
  double mean_dn(double light_dn, std::size_t i) const {
    const double own = light_dn * static_cast<double>(factor.data[i]);
    return kBlackDn + static_cast<double>(offset_dn.data[i]) + std::min(own, kKneeDn) +
           kSlope * std::max(0.0, own - kKneeDn);
  }
  /// One image of this light, rounded and clipped.
  CameraImages taken(double light_dn) const {
    CameraImages out;
    out.images.push_back(ImageF(kWidth, kHeight));
    for (std::size_t i = 0; i < factor.size(); ++i)
      out.images[0].as_floats()[i] =
          static_cast<float>(std::round(std::clamp(mean_dn(light_dn, i), 0.0, sensor.max_dn())));
    return out;
  }
};

TEST(Straightened, PixelsSayTheLightThatAllOfThemSaw) {
  const UnevenSensor uneven;
  for (const double light_dn : {0.0, 40.0, 119.0, 121.0, 180.0}) {
    const CameraImages taken = uneven.taken(light_dn);
    const auto straight = straightened(taken, uneven.sensor);
    for (std::size_t i = 0; i < uneven.factor.size(); ++i) {
      if (i == UnevenSensor::kHot && light_dn > 140.0) continue;  // clipped
      ASSERT_NEAR(static_cast<double>(straight->images[0][i]), UnevenSensor::kBlackDn + light_dn, 0.55)
          << light_dn << " DN, pixel " << i;
    }
  }
}

// The bound is what nearly all pixels reach: a hot one does not take the range from the others, and what is
// clipped counts as clipped whatever its pixel's gain is.
TEST(Straightened, WhatIsClippedStaysClipped) {
  const UnevenSensor uneven;
  const auto white = straightened(uneven.taken(1000.0), uneven.sensor);
  const double bound = white->saturation_dn();
  EXPECT_GT(bound, 0.95 * (uneven.sensor.response.inverse(255.0 - 20.0) + 20.0));
  EXPECT_LT(bound, uneven.sensor.response.inverse(255.0 - 20.0) + 20.0);
  for (const float value : white->images[0].floats().data) ASSERT_GE(static_cast<double>(value), bound);
  const CameraImages black{.images = {ImageF(UnevenSensor::kWidth, UnevenSensor::kHeight, 0.0F)}};
  const auto dark = straightened(black, uneven.sensor);
  for (const float value : dark->images[0].floats().data) ASSERT_LE(value, 0.0F);
}

}  // namespace
}  // namespace fringetwin::compare::gray_pair_test
