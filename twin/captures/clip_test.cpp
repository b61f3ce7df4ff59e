// SPDX-License-Identifier: Apache-2.0
// Truth: fringes of known brightness written into images, with a full well of known level.
//
// | check                        | tolerance   | origin                                            |
// |------------------------------|-------------|---------------------------------------------------|
// | a well that clips last       | exact       | every value above it is that value                |
// | a well before the read noise | 3.5 sigma   | found from the low end of what the noise smears    |
#include "twin/captures/clip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace fringetwin::clip_test {
namespace {

struct Scene {
  double brightest_dn = 3700.0;  ///< of the brightest pixel's fringe
  double fall = 0.3;             ///< of the brightness over the image
  double contrast = 0.45;        ///< amplitude of the fringes over full light, about a half of it
  double noise_dn = 15.0;        ///< before the well
  double well_dn = 1e9;
  double read_dn = 0.0;  ///< after the well
  int steps = 4, bit_depth = 12;
};

Fringes make_fringes(int steps) {
  Fringes fringes;
  fringes.unwrap = Unwrap::none;
  fringes.steps = steps;
  fringes.directions = {{Axis::x, {13.0, 14.0}, {0.0, 0.0}, std::nullopt}};
  return fringes;
}

CameraImages make_images(const Scene& s, unsigned seed = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  CameraImages out;
  out.camera = "left";
  out.bit_depth = s.bit_depth;
  const double full = (1 << s.bit_depth) - 1;
  for (int k = 0; k < 2 * s.steps; ++k) {
    ImageF image(200, 150);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const double light = s.brightest_dn * (1.0 - s.fall * (x + 0.4 * y) / 260.0);
        const double phase =
            2.0 * std::numbers::pi * (x / (k < s.steps ? 6.3 : 6.9) + (k % s.steps) / double(s.steps));
        const double dn = light * (0.5 + s.contrast * std::cos(phase)) + s.noise_dn * normal(random);
        image(x, y) = static_cast<float>(
            std::clamp(std::round(std::min(dn, s.well_dn) + s.read_dn * normal(random)), 0.0, full));
      }
    out.images.push_back(std::move(image));
  }
  return out;
}

std::optional<Clip> clip_of(const Scene& s) {
  Sensor sensor;
  sensor.bit_depth = s.bit_depth;
  if (s.read_dn > 0.0) sensor.read_noise_dn = s.read_dn;
  return find_clip(make_images(s), make_fringes(s.steps), sensor);
}

TEST(FindClip, AFullWellBelowFullScaleIsFoundAndCounted) {
  for (const int steps : {3, 4, 7}) {
    const Scene s{.well_dn = 3000.0, .steps = steps};
    const auto clip = clip_of(s);
    ASSERT_TRUE(clip) << steps;
    EXPECT_EQ(clip->dn, 3000.0);
    std::uint64_t n = 0;
    for (const GrayImage& image : make_images(s).images)
      image.for_each([&n](float value) { n += value == 3000.0F ? 1 : 0; });
    EXPECT_EQ(clip->n, n);
  }
}

TEST(FindClip, AFullWellBeforeTheReadNoiseIsFound) {
  const auto clip = clip_of({.well_dn = 3000.0, .read_dn = 3.0});
  ASSERT_TRUE(clip);
  EXPECT_NEAR(clip->dn, 3000.0, 3.5 * 3.0 + 0.5 * (1.0 + 4.0 * 3.0));
  EXPECT_LT(clip->dn, 3000.0 - 2.0 * 3.0);  // hardly a clipped value stays
}

// Three quarters of the pixels are above the well in all steps, and say nothing of fringes that go on above
// it; the dark corner's do.
TEST(FindClip, AWellThatMostPixelsAreBeyondIsFound) {
  const auto clip = clip_of({.brightest_dn = 7500.0, .fall = 0.6, .contrast = 0.1, .well_dn = 2000.0});
  ASSERT_TRUE(clip);
  EXPECT_EQ(clip->dn, 2000.0);
}

TEST(FindClip, ValuesThatJustEndAreNoClip) {
  EXPECT_FALSE(clip_of({}));
  EXPECT_FALSE(clip_of({.read_dn = 3.0}));
  EXPECT_FALSE(clip_of({.fall = 0.0}));
  EXPECT_FALSE(clip_of({.brightest_dn = 200.0, .noise_dn = 0.6, .bit_depth = 8}));
}

TEST(FindClip, ValuesInStepsOfSeveralAreNoClip) {
  CameraImages images = make_images({});
  for (GrayImage& image : images.images)
    for (float& v : image.as_floats()) v = 16.0F * std::floor(v / 16.0F);
  EXPECT_FALSE(find_clip(images, make_fringes(4), Sensor{}));
}

TEST(FindClip, TheBrightEndOfFringesWithoutNoiseIsNoClip) {
  EXPECT_FALSE(clip_of({.fall = 0.0, .noise_dn = 0.0}));
  EXPECT_FALSE(clip_of({.brightest_dn = 200.0, .fall = 0.0, .noise_dn = 0.0, .bit_depth = 8}));
}

TEST(FindClip, FullScaleAndIrradianceHaveNone) {
  EXPECT_FALSE(clip_of({.brightest_dn = 5000.0}));  // clips at 4095, which saturation_dn() knows
  CameraImages images = make_images({.well_dn = 3000.0});
  images.radiance = true;
  EXPECT_FALSE(find_clip(images, make_fringes(4), Sensor{}));
}

TEST(FindClip, SaturationIsTheClip) {
  CameraImages images = make_images({.well_dn = 3000.0});
  EXPECT_EQ(images.saturation_dn(), 4095.0);
  images.clip = find_clip(images, make_fringes(4), Sensor{});
  EXPECT_EQ(images.saturation_dn(), 3000.0);
}

}  // namespace
}  // namespace fringetwin::clip_test
