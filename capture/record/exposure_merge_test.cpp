// SPDX-License-Identifier: Apache-2.0
#include "capture/record/exposure_merge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace fringetwin::testing::exposure_merge_test {
namespace {

using namespace fringetwin::capture;

constexpr double kBlackDn = 8.0, kMaxDn = 255.0;

/// A pixel of radiance rate r DN/ms, image k with the factor f[k].
BracketExposure exposure(double ms, const std::vector<double>& rates, const std::vector<double>& factors) {
  return {ms, [=](std::size_t k) {
            ImageF image(static_cast<int>(rates.size()), 1);
            for (std::size_t i = 0; i < rates.size(); ++i)
              image.data[i] = static_cast<float>(std::min(kMaxDn, kBlackDn + rates[i] * factors[k] * ms));
            return image;
          }};
}

std::vector<ImageF> merge(std::vector<BracketExposure> exposures, std::size_t n) {
  std::vector<ImageF> merged(n);
  merge_exposures(std::move(exposures), n, kBlackDn, kMaxDn,
                  [&](std::size_t k, const ImageF& image) { merged[k] = image; });
  return merged;
}

// Linear light: whatever exposure a pixel comes from, the merged value is that of the shortest one.
TEST(ExposureMerge, LinearLightComesOutAsAtTheShortestExposure) {
  const std::vector<double> rates = {0.1, 1.0, 10.0, 50.0}, factors = {0.2, 1.0, 0.6};
  const auto merged =
      merge({exposure(8, rates, factors), exposure(2, rates, factors), exposure(32, rates, factors)}, 3);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < rates.size(); ++i)
      EXPECT_NEAR(merged[k].data[i], kBlackDn + rates[i] * factors[k] * 2.0, 1e-4) << k << " " << i;
}

// One saturated image of the sequence moves all images of the pixel to a shorter exposure.
TEST(ExposureMerge, AllImagesOfAPixelComeFromOneExposure) {
  const auto constant = [](double ms, float first, float second) {
    return BracketExposure{ms, [=](std::size_t k) { return ImageF(1, 1, k == 0 ? first : second); }};
  };
  // at 10 ms the first image is saturated, the second is not; distinct values tell the exposures apart
  const auto merged = merge({constant(1, 40, 20), constant(10, 255, 100)}, 2);
  EXPECT_EQ(merged[0](0, 0), 40.0f);
  EXPECT_EQ(merged[1](0, 0), 20.0f);
  const auto longer = merge({constant(1, 40, 20), constant(10, 254, 108)}, 2);
  EXPECT_NEAR(longer[1](0, 0), 8.0 + (108.0 - 8.0) / 10.0, 1e-5);
}

TEST(ExposureMerge, SaturatedEverywhereStaysSaturated) {
  const auto merged = merge({exposure(2, {500.0}, {1.0, 0.1}), exposure(4, {500.0}, {1.0, 0.1})}, 2);
  EXPECT_EQ(merged[0](0, 0), 255.0f);
  EXPECT_EQ(merged[1](0, 0), 255.0f);
}

}  // namespace
}  // namespace fringetwin::testing::exposure_merge_test
