// SPDX-License-Identifier: Apache-2.0
// Numbers of the preview against what went in.
//
// | check      | tolerance | origin                                                                      |
// |------------|-----------|-----------------------------------------------------------------------------|
// | modulation | 0.5 DN    | 8 bit quantisation of the projected levels and of the camera                |
// | contrast   | 1e-3      | the blur's kernel is sampled at whole pixels, sigma >= 1 px                 |
// | noise      | 5 %       | 4 sigma of the variance of 20,000 values is 4 %                             |
#include "capture/adjust/preview.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/capture/loop_rig.hpp"

namespace fringetwin::testing::preview_test {
namespace {

using namespace fringetwin::capture;
using testing::loop_twin;
using testing::LoopRig;
constexpr int kWidth = 160, kHeight = 120;
constexpr double kPitch = 16.0;

ImageF blurred(const ImageF& image, double sigma) {
  if (sigma == 0.0) return image;
  const int reach = static_cast<int>(std::ceil(6.0 * sigma));
  std::vector<double> kernel;
  double sum = 0.0;
  for (int k = -reach; k <= reach; ++k) sum += kernel.emplace_back(std::exp(-0.5 * k * k / (sigma * sigma)));
  const auto pass = [&](const ImageF& in, bool along_x) {
    ImageF out(in.width, in.height);
    for (int y = 0; y < in.height; ++y)
      for (int x = 0; x < in.width; ++x) {
        double value = 0.0;
        for (int k = -reach; k <= reach; ++k) {
          // as if the scene went on periodically: the fringes do
          const int u = along_x ? (x + k + 10 * in.width) % in.width : x;
          const int v = along_x ? y : (y + k + 10 * in.height) % in.height;
          value += kernel[static_cast<std::size_t>(k + reach)] / sum * static_cast<double>(in(u, v));
        }
        out(x, y) = static_cast<float>(value);
      }
    return out;
  };
  return pass(pass(image, true), false);
}

/// A part with spots, under fringes of amplitude 0.4 about 0.5 of `light_dn`; all seen through a blur.
std::vector<ImageF> scene(double light_dn, double sigma, double noise_dn, unsigned seed,
                          double texture = 0.3) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<ImageF> steps;
  for (int n = 0; n < 5; ++n) {  // the last is the first once more
    ImageF image(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double albedo = 1.0 - texture * ((x / 7 + y / 5) % 2);
        const double fringe = 0.5 + 0.4 * std::cos(2.0 * std::numbers::pi * (x / kPitch + n / 4.0));
        image(x, y) = static_cast<float>(10.0 + light_dn * albedo * fringe);
      }
    image = blurred(image, sigma);
    for (float& v : image.data) v += static_cast<float>(noise_dn * noise(random));
    steps.push_back(std::move(image));
  }
  return steps;
}

PreviewNumbers numbers(std::vector<ImageF> images, int bits = 12) {
  Sensor sensor;
  sensor.bit_depth = bits;
  sensor.black_level_dn = 10.0;
  const ImageF again = images.back();
  images.pop_back();
  return preview_numbers("left", images, again, sensor, 5.0);
}

TEST(CapturePreview, ModulationAndContrastAreWhatWentIn) {
  const PreviewNumbers sharp = numbers(scene(1000.0, 0.0, 0.0, 1, 0.0));
  EXPECT_NEAR(sharp.modulation_dn, 400.0, 1e-3);
  EXPECT_NEAR(sharp.contrast, 0.8, 1e-6);
  EXPECT_NEAR(sharp.mean_dn, 510.0, 1e-3);
  EXPECT_EQ(sharp.lit_share, 1.0);
  EXPECT_EQ(sharp.saturated_share, 0.0);
  EXPECT_NEAR(sharp.focus, 0.0, 1e-9);  // no texture
  for (const double sigma : {1.0, 2.0, 4.0}) {
    const double kept = std::exp(-2.0 * std::pow(std::numbers::pi * sigma / kPitch, 2));
    EXPECT_NEAR(numbers(scene(1000.0, sigma, 0.0, 1, 0.0)).contrast, 0.8 * kept, 1e-3) << sigma;
  }
}

TEST(CapturePreview, BlurLowersTheFocusMeasureAndLightDoesNotChangeIt) {
  double before = 1e300;
  for (const double sigma : {0.0, 0.5, 1.0, 1.5, 2.0, 3.0}) {
    const double focus = numbers(scene(1000.0, sigma, 3.0, 1)).focus;
    EXPECT_LT(focus, 0.95 * before) << sigma;
    before = focus;
  }
  EXPECT_GT(before, 0.0);
  const double focus = numbers(scene(1000.0, 1.0, 0.0, 1)).focus;
  EXPECT_NEAR(numbers(scene(300.0, 1.0, 0.0, 1)).focus, focus, 1e-4 * focus);
  EXPECT_NEAR(numbers(scene(1000.0, 1.0, 30.0, 1)).focus, focus, 0.05 * focus);
}

TEST(CapturePreview, NoiseIsNoFocus) {
  // 30 DN of noise on an even part: without the correction the measure would be 0.375 * 225/500^2
  const double uncorrected = 0.375 * 30.0 * 30.0 / 4.0 / (500.0 * 500.0);
  EXPECT_LT(numbers(scene(1000.0, 0.0, 30.0, 1, 0.0)).focus, 0.05 * uncorrected);
}

TEST(CapturePreview, SaturatedAndDarkPixelsAreCountedAndLeftOut) {
  std::vector<ImageF> images = scene(1000.0, 0.0, 0.0, 1, 0.0);
  for (ImageF& image : images)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        if (y < kHeight / 4) image(x, y) = 4095.0f;
        if (y >= kHeight / 2) image(x, y) = 10.0f;
      }
  const PreviewNumbers found = numbers(std::move(images));
  EXPECT_NEAR(found.saturated_share, 0.25, 1e-9);
  EXPECT_NEAR(found.lit_share, 0.25, 1e-9);
  EXPECT_NEAR(found.modulation_dn, 400.0, 1e-3);
}

TEST(CapturePreview, LooksThroughTheCameras) {
  Twin twin = loop_twin(2);
  twin.fringes.amplitude = 0.4;
  LoopRig rig(twin);
  CapturePlan plan;
  plan.settle_frames = 0;
  plan.latency_ms = rig.world->latency_ms;
  Preview preview(twin, rig.cameras, *rig.display, plan);
  for (int i = 0; i < 2; ++i)
    for (const PreviewNumbers& found : preview.look()) {
      EXPECT_NEAR(found.modulation_dn, 0.4 * 255.0, 0.5);
      EXPECT_NEAR(found.mean_dn, 0.5 * 255.0, 0.5);
      EXPECT_NEAR(found.contrast, 0.8, 0.005);
      EXPECT_EQ(found.saturated_share, 0.0);
    }
  EXPECT_EQ(rig.world->n_shown, 8u);
  twin.fringes.steps = 0;  // Gray code only
  Preview gray(twin, rig.cameras, *rig.display, plan);
  const PreviewNumbers found = gray.look()[1];
  EXPECT_EQ(found.saturated_share, 1.0);
  EXPECT_EQ(found.mean_dn, 127.5);
}

}  // namespace
}  // namespace fringetwin::testing::preview_test
