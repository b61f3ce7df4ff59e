// SPDX-License-Identifier: Apache-2.0
// Truth: pixels averaged by hand over a part that ends inside them. No tolerances: kept or left out.
#include "measure/decode/mixed_pixels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace fringetwin::measure::mixed_pixels_test {
namespace {

constexpr int kSize = 24, kEdge = 12;  ///< the part begins in column kEdge

/// A flat part of amplitude 60 DN whose first column is filled to the share `filled`; coordinate 0.8 px per
/// px.
CameraDecode edge(double filled, float sigma_px) {
  CameraDecode d;
  d.camera = "camera";
  d.flags = ImageU8(kSize, kSize, kValid);
  DirectionDecode x;
  x.pitches_px = {13};
  x.wrapped_rad.assign(1, ImageF(kSize, kSize, 0.0f));
  x.amplitude_dn.assign(1, ImageF(kSize, kSize, 0.0f));
  x.coordinate_px = ImageD(kSize, kSize, std::nan(""));
  x.coordinate_sigma_px = ImageF(kSize, kSize, sigma_px);
  for (int j = 0; j < kSize; ++j)
    for (int i = kEdge; i < kSize; ++i) {
      const double share = i == kEdge ? filled : 1.0;
      x.amplitude_dn[0](i, j) = static_cast<float>(60.0 * share);
      x.coordinate_px(i, j) = 100.0 + 0.8 * (i + 0.5 * (1.0 - share));  // of the centroid of the filled part
    }
  d.directions = {x};
  return d;
}

std::size_t left_out(const CameraDecode& d) {
  std::size_t n = 0;
  (void)without_mixed_pixels(d, n);
  return n;
}

TEST(MixedPixels, PartlyFilledPixelsAreLeftOut) {
  std::size_t n = 0;
  const CameraDecode d = without_mixed_pixels(edge(0.4, 0.005f), n);
  EXPECT_EQ(n, static_cast<std::size_t>(kSize));
  EXPECT_TRUE(std::isnan(d.directions[0].coordinate_px(kEdge, 7)));
  EXPECT_TRUE(std::isfinite(d.directions[0].coordinate_px(kEdge + 1, 7)));
  EXPECT_EQ(d.directions[0].coordinate_sigma_px.width, kSize);
}

TEST(MixedPixels, FullPixelsAtAnEdgeStay) { EXPECT_EQ(left_out(edge(1.0, 0.005f)), 0u); }

TEST(MixedPixels, AShiftBelowTheNoiseStays) {
  EXPECT_EQ(left_out(edge(0.9, 0.045f)), 0u);  // shift 0.05 px of 0.8 slope: 0.04
  EXPECT_EQ(left_out(edge(0.9, 0.035f)), static_cast<std::size_t>(kSize));
}

TEST(MixedPixels, TheEdgeOfTheImageIsNoBorder) {
  CameraDecode d = edge(1.0, 0.005f);
  for (int j = 0; j < kSize; ++j) d.directions[0].amplitude_dn[0](kSize - 1, j) = 30.0f;  // vignetting, say
  EXPECT_EQ(left_out(d), 0u);
}

TEST(MixedPixels, LightThatFadesToNothingDisplacesItsLastPixel) {
  // amplitude 10 i - 8: at the last pixel 2, falling by 10 per px: first moment 10/(12*2) = 0.42 px of 0.8
  // slope
  for (const auto& [sigma_px, n] : {std::pair{0.31f, kSize}, {0.35f, 0}}) {
    CameraDecode d = edge(1.0, sigma_px);
    for (int j = 0; j < kSize; ++j)
      for (int i = kEdge; i < kSize; ++i)
        d.directions[0].amplitude_dn[0](i, j) = 10.0f * static_cast<float>(i - kEdge) + 2.0f;
    EXPECT_EQ(left_out(d), static_cast<std::size_t>(n)) << sigma_px;
  }
}

// Light that falls by 10 DN per px would be 40 DN at the border: of that 20 DN fill a half, whose centroid
// lies a quarter off; 38 DN are full but for 0.025, and the slope of 12 DN moves them by 12/(12 * 38).
TEST(MixedPixels, TheFullAmplitudeIsExtrapolatedFromTheNeighbours) {
  EXPECT_DOUBLE_EQ(centroid_shift_px(20.0, 50.0, 60.0), 0.25);
  EXPECT_DOUBLE_EQ(centroid_shift_px(38.0, 50.0, 60.0), 1.0 / 38.0);
  EXPECT_DOUBLE_EQ(centroid_shift_px(60.0, 60.0, 60.0), 0.0);
}

TEST(MixedPixels, AHoleHasABorderAllRound) {
  CameraDecode d = edge(1.0, 0.005f);
  DirectionDecode& x = d.directions[0];
  x.coordinate_px(18, 12) = std::nan("");
  for (const int i : {17, 19}) x.amplitude_dn[0](i, 12) = 40.0f;
  EXPECT_EQ(left_out(d), 2u);
}

TEST(MixedPixels, OneDirectionIsEnoughForBoth) {
  CameraDecode d = edge(0.5, 0.005f);
  d.directions.push_back(edge(1.0, 0.005f).directions[0]);
  d.directions[1].axis = Axis::y;
  std::size_t n = 0;
  const CameraDecode out = without_mixed_pixels(d, n);
  EXPECT_EQ(n, static_cast<std::size_t>(kSize));
  EXPECT_TRUE(std::isnan(out.directions[1].coordinate_px(kEdge, 3)));
}

TEST(MixedPixels, CodeWithoutPhasesIsLeftAlone) {
  CameraDecode d = edge(0.4, 0.005f);
  d.directions[0].wrapped_rad.clear();
  EXPECT_EQ(left_out(d), 0u);
}

}  // namespace
}  // namespace fringetwin::measure::mixed_pixels_test
