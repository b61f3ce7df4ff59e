// SPDX-License-Identifier: Apache-2.0
// Maps of pixels from drawn images of a sensor whose pixels are known, under light that is uneven and
// flickers.
//
// | check                          | tolerance | origin                                                     |
// |--------------------------------|-----------|------------------------------------------------------------|
// | error of a map / stated noise  | 4 %       | 64,000 pixels: 0.3 %; what 31 x 31 pixels around add: 1 %; |
// |                                |           | offsets' noise over the level of the image's corners: 2 %  |
// | rms of the pixels              | 2 %       | 64,000 pixels: 0.3 %, the noise taken off: 0.3 %           |
// | mean factor, mean offset       | 1e-5      | floats, 6e-8 each; offsets of 1.5 DN                       |
#include "calib/photometry/pixel_maps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/support/calib/drawn_photometry.hpp"

namespace fringetwin::calib::pixel_maps_test {
namespace {

using namespace testing;

constexpr double kPrnu = 0.01, kDsnuDn = 1.5, kLevelDn = 170.0;

/// Pixels that are known, and their images.
struct DrawnPixels {
  TrueSensor sensor = {};
  double prnu = kPrnu, dsnu_dn = kDsnuDn, knee_dn = 1e9, slope = 1.0;
  std::mt19937_64 random{21};
  ImageF factor{kDrawnWidth, kDrawnHeight, 1.0F}, offset_dn{kDrawnWidth, kDrawnHeight, 0.0F};

  void draw_pixels() {
    std::normal_distribution<double> normal;
    for (float& f : factor.data) f = static_cast<float>(1.0 + prnu * normal(random));
    for (float& o : offset_dn.data) o = static_cast<float>(dsnu_dn * normal(random));
  }
  /// Falls to 0.85 towards the corners, and by 8 % from the left to the right.
  static double light(int x, int y) {
    const double u = (x - 0.5 * (kDrawnWidth - 1)) / (0.5 * kDrawnWidth),
                 v = (y - 0.5 * (kDrawnHeight - 1)) / (0.5 * kDrawnWidth);
    return (1.0 - 0.04 * u) * (1.0 - 0.11 * (u * u + v * v));
  }
  ImageF image(double level_dn) {
    ImageF out(kDrawnWidth, kDrawnHeight);
    for (int y = 0; y < kDrawnHeight; ++y)
      for (int x = 0; x < kDrawnWidth; ++x) {
        TrueSensor own = sensor;
        own.black_dn += static_cast<double>(offset_dn(x, y));
        const double signal = level_dn * light(x, y) * static_cast<double>(factor(x, y));
        out(x, y) = expose(std::min(signal, knee_dn) + slope * std::max(0.0, signal - knee_dn), own, random);
      }
    return out;
  }
  std::vector<GrayImage> images(double level_dn, int n, double flicker) {
    std::vector<GrayImage> out;
    std::normal_distribution<double> normal;
    for (int k = 0; k < n; ++k) out.push_back(image(level_dn * (1.0 + flicker * normal(random))));
    return out;
  }
};

ImageF mean_of(const std::vector<GrayImage>& images) {
  ImageF mean(images[0].width, images[0].height, 0.0F);
  for (const GrayImage& image : images)
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean.data[i] += image[i] / static_cast<float>(images.size());
  return mean;
}

std::optional<PixelMapEstimate> factors_of(const std::vector<GrayImage>& flat, const TrueSensor& sensor,
                                           const PixelMapEstimate* offsets,
                                           const CameraResponse& response = {}) {
  const FlatField field = fit_flat_field(mean_of(flat), sensor.black_dn, 255.0, "left");
  return pixel_factors(flat, {.black_level_dn = sensor.black_dn,
                              .saturation_dn = 255.0,
                              .response = response,
                              .offsets = offsets,
                              .field = field});
}

double mean(const ImageF& map) {
  return std::accumulate(map.data.begin(), map.data.end(), 0.0) / static_cast<double>(map.size());
}
double rms_about_mean(const ImageF& map) {
  const double middle = mean(map);
  double squares = 0.0;
  for (const float v : map.data) squares += std::pow(static_cast<double>(v) - middle, 2);
  return std::sqrt(squares / static_cast<double>(map.size()));
}
/// The rms of what a map differs from the truth by, but for a constant.
double error_of(const ImageF& map, const ImageF& truth) {
  ImageF off = map;
  for (std::size_t i = 0; i < off.size(); ++i) off.data[i] -= truth.data[i];
  return rms_about_mean(off);
}

void expect_right(const PixelMapEstimate& found, const ImageF& truth, double at) {
  EXPECT_TRUE(found.is_told());
  EXPECT_NEAR(mean(found.map), at, 1e-5);
  EXPECT_NEAR(error_of(found.map, truth) / found.noise, 1.0, 0.04);
  EXPECT_NEAR(found.rms, rms_about_mean(truth), 0.02 * rms_about_mean(truth));
  EXPECT_EQ(found.n_unknown, 0u);
}

TEST(PixelMaps, AreThoseThatWerePutIn) {
  DrawnPixels drawn;
  drawn.draw_pixels();
  const auto offsets = pixel_offsets(drawn.images(0.0, 16, 0.0));
  ASSERT_TRUE(offsets);
  expect_right(*offsets, drawn.offset_dn, 0.0);
  EXPECT_LT(offsets->noise, 0.25);  // 0.9 DN and rounding, of 16 images
  const auto factors = factors_of(drawn.images(kLevelDn, 16, 0.02), drawn.sensor, &*offsets);
  ASSERT_TRUE(factors);
  expect_right(*factors, drawn.factor, 1.0);
  EXPECT_LT(factors->noise, 0.4 * kPrnu);
}

// The same beyond a knee: what the pixels' gains do to the gray values is less there, what they are is not.
TEST(PixelMaps, FactorsAreOfTheLightAndNotOfTheGrayValues) {
  DrawnPixels drawn{.dsnu_dn = 0.0, .knee_dn = 60.0, .slope = 0.6};
  drawn.draw_pixels();
  const CameraResponse knee = knee_response(drawn.knee_dn, drawn.slope);
  const auto factors = factors_of(drawn.images(kLevelDn, 64, 0.0), drawn.sensor, nullptr, knee);
  ASSERT_TRUE(factors);
  EXPECT_NEAR(factors->rms, kPrnu, 0.02 * kPrnu);
  const auto bent = factors_of(drawn.images(kLevelDn, 64, 0.0), drawn.sensor, nullptr);
  ASSERT_TRUE(bent);
  EXPECT_LT(bent->rms, 0.9 * kPrnu) << "else the knee does nothing here";
}

// A pixel that light clips has no factor; it does not spoil those of its neighbours.
TEST(PixelMaps, ClippedPixelsAreUnknown) {
  DrawnPixels drawn{.dsnu_dn = 0.0};
  drawn.draw_pixels();
  for (int x = 100; x < 120; ++x) drawn.factor(x, 77) = 3.0F;
  std::vector<GrayImage> flat = drawn.images(kLevelDn, 16, 0.0);
  const auto factors = factors_of(flat, drawn.sensor, nullptr);
  ASSERT_TRUE(factors);
  EXPECT_EQ(factors->n_unknown, 20u);
  for (int x = 100; x < 120; ++x) EXPECT_EQ(factors->map(x, 77), 1.0F);
  EXPECT_NEAR(factors->rms, kPrnu, 0.02 * kPrnu);
}

TEST(PixelMaps, OfLikePixelsAreNoiseAndSaySo) {
  DrawnPixels drawn{.prnu = 0.0, .dsnu_dn = 0.0};
  const auto offsets = pixel_offsets(drawn.images(0.0, 4, 0.0));
  const auto factors = factors_of(drawn.images(kLevelDn, 4, 0.0), drawn.sensor, nullptr);
  ASSERT_TRUE(offsets && factors);
  EXPECT_FALSE(offsets->is_told());
  EXPECT_FALSE(factors->is_told());
  EXPECT_FALSE(pixel_offsets(drawn.images(0.0, 1, 0.0))) << "one image has no noise to tell";
}

// Values that never change: their means are no better than rounding, however many there are.
TEST(PixelMaps, RoundingIsInTheNoise) {
  DrawnPixels drawn{.sensor = {.read_noise_dn = 0.0}, .dsnu_dn = 0.5};
  drawn.draw_pixels();
  const auto offsets = pixel_offsets(drawn.images(0.0, 16, 0.0));
  ASSERT_TRUE(offsets);
  EXPECT_NEAR(error_of(offsets->map, drawn.offset_dn) / offsets->noise, 1.0, 0.04);
}

}  // namespace
}  // namespace fringetwin::calib::pixel_maps_test
