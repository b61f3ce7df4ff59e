// SPDX-License-Identifier: Apache-2.0
// Inside a surface: away from borders, from steps of the projector coordinate, but not from noise. No
// tolerances: pixels are in or out.
#include "compare/gray/interior_mask.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace fringetwin::compare::interior_mask_test {
namespace {

using measure::CameraDecode;

constexpr int kWidth = 40, kHeight = 30;

/// A coordinate that grows by 0.8 px a column and 0.1 px a row, and bends gently.
CameraDecode decode(double sigma_px = 0.01) {
  CameraDecode d;
  d.flags = ImageU8(kWidth, kHeight, measure::kValid);
  measure::DirectionDecode direction;
  direction.coordinate_px = ImageD(kWidth, kHeight);
  direction.coordinate_sigma_px = ImageF(kWidth, kHeight, static_cast<float>(sigma_px));
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) direction.coordinate_px(x, y) = 300.0 + 0.8 * x + 0.1 * y + 0.01 * x * x;
  d.directions.push_back(direction);
  return d;
}

ImageD& coordinate(CameraDecode& d) { return d.directions[0].coordinate_px; }

ImageU8 everything() { return ImageU8(kWidth, kHeight, 1); }

/// Two pixels from the border are missing: one has no eight neighbours, the next lies beside it.
bool inside(int x, int y) { return x >= 2 && y >= 2 && x < kWidth - 2 && y < kHeight - 2; }

TEST(Interior, ASmoothSurfaceLosesItsBorderOnly) {
  const CameraDecode d = decode();
  const ImageU8 mask = interior_mask(everything(), &d, &d);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) EXPECT_EQ(mask(x, y), inside(x, y) ? 1 : 0) << x << ' ' << y;
}

TEST(Interior, AHoleTakesTwoPixelsAround) {
  ImageU8 given = everything();
  given(20, 15) = 0;
  const ImageU8 mask = interior_mask(given, nullptr, nullptr);
  for (int y = 2; y < kHeight - 2; ++y)
    for (int x = 2; x < kWidth - 2; ++x)
      EXPECT_EQ(mask(x, y), std::max(std::abs(x - 20), std::abs(y - 15)) > 2 ? 1 : 0) << x << ' ' << y;
}

TEST(Interior, AStepInTheCoordinateIsABorder) {
  for (const bool in_real : {true, false}) {
    CameraDecode stepped = decode();
    const CameraDecode smooth = decode();
    for (int y = 0; y < kHeight; ++y)
      for (int x = 20; x < kWidth; ++x) coordinate(stepped)(x, y) += 3.0;  // the sheet behind
    const ImageU8 mask = in_real ? interior_mask(everything(), &stepped, &smooth)
                                 : interior_mask(everything(), &smooth, &stepped);
    // the second difference sees it in columns 19 and 20; their neighbours go with them
    for (int x = 2; x < kWidth - 2; ++x) EXPECT_EQ(mask(x, 15), x < 18 || x > 21 ? 1 : 0) << x;
  }
}

TEST(Interior, ASmallStepIsNone) {
  CameraDecode d = decode();
  for (int y = 0; y < kHeight; ++y)
    for (int x = 20; x < kWidth; ++x) coordinate(d)(x, y) += 0.9;
  EXPECT_EQ(interior_mask(everything(), &d, nullptr)(20, 15), 1);
}

TEST(Interior, WhatIsNotUnwrappedIsNoStep) {
  CameraDecode d = decode();
  coordinate(d)(20, 15) = kNaN;
  EXPECT_EQ(interior_mask(everything(), &d, nullptr)(21, 15), 1);
  d.directions[0].coordinate_px = ImageD();  // code only, or one pitch
  EXPECT_EQ(interior_mask(everything(), &d, nullptr)(20, 15), 1);
}

TEST(Interior, NoiseIsNoStep) {
  // The second difference scatters by sqrt(6) sigma = 1.22 px: without the sigma, 41 % of the pixels would be
  // kinks. 12 sigma are 4.9 of its standard errors: 1 in 10^6.
  const double sigma_px = 0.5;
  CameraDecode d = decode(sigma_px);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, sigma_px);
  for (double& x : coordinate(d).data) x += normal(random);
  const ImageU8 mask = interior_mask(everything(), &d, nullptr);
  for (int y = 2; y < kHeight - 2; ++y)
    for (int x = 2; x < kWidth - 2; ++x) EXPECT_EQ(mask(x, y), 1) << x << ' ' << y;
  for (float& s : d.directions[0].coordinate_sigma_px.data) s = 0.01F;  // as if it were not noise
  const ImageU8 strict = interior_mask(everything(), &d, nullptr);
  EXPECT_LT(std::count(strict.data.begin(), strict.data.end(), 1),
            std::count(mask.data.begin(), mask.data.end(), 1) / 2);
}

TEST(Interior, ASigmaThatIsUnknownCountsAsNone) {
  CameraDecode d = decode();
  for (float& s : d.directions[0].coordinate_sigma_px.data) s = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(interior_mask(everything(), &d, nullptr)(20, 15), 1);
  for (int y = 0; y < kHeight; ++y) coordinate(d)(20, y) += 2.0;
  EXPECT_EQ(interior_mask(everything(), &d, nullptr)(20, 15), 0);
}

}  // namespace
}  // namespace fringetwin::compare::interior_mask_test
