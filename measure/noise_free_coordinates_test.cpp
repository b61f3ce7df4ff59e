// SPDX-License-Identifier: Apache-2.0
// Coordinates of images without noise in the place of measured ones, in the box of the fits.
#include "measure/noise_free_coordinates.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/measure/synthetic_fringes.hpp"

namespace fringetwin::measure::noise_free_coordinates_test {
namespace {

using testing::FringeScene;

constexpr int kX0 = 180, kY0 = 90, kSide = 5;  ///< of the pixels of a small object

/// A fit of the pixels of a small object.
std::pair<PointCloud, std::vector<ObjectFit>> small_object() {
  PointCloud cloud;
  ObjectFit fit;
  for (int y = kY0; y < kY0 + kSide; ++y)
    for (int x = kX0; x < kX0 + kSide; ++x) {
      fit.index.push_back(cloud.q_cam_px.size());
      cloud.q_cam_px.emplace_back(x, y);
    }
  return {cloud, {fit}};
}

/// Images without noise of a lamp that flickers by 2 %, and how they are decoded with their light taken out.
struct Flickering {
  Fringes fringes = testing::one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 1, 2});
  FringeScene scene = testing::noisy_scene(0.0);
  DecodeOptions options = testing::projector_of_width(1280);
  CameraImages images;
  Flickering() {
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 400; ++x)
        if (x >= 100 && (std::abs(x - kX0 - kSide / 2) > kSide || std::abs(y - kY0 - kSide / 2) > kSide))
          scene.albedo(x, y) = 0.0F;
    scene.quantised = false;
    for (int k = 0; k < 12; ++k) scene.light.push_back(1.0 + 0.02 * std::sin(5.0 * k));
    images = project(fringes, scene);
    options.light = LightOptions{.black_level_dn = scene.black_dn};
  }
};

// A small object beside a large one: the 121 lit pixels of its box are too few to tell the light, which the
// whole image tells. Left in, it would move a coordinate by 0.01 px and more and be stated as bias of the
// method. What the whole image leaves of it is its fit's end: factors settle within 1e-6.
TEST(NoiseFreeCoordinates, TheLightOfABoxIsThatOfTheImage) {
  const Flickering lamp;
  const auto [cloud, fits] = small_object();
  const CameraDecode whole = decode(lamp.images, lamp.fringes, lamp.options);
  ASSERT_TRUE(whole.light_taken_out);
  DecodeOptions as_it_is = lamp.options;
  as_it_is.light.reset();
  const CameraDecode flickers = decode(lamp.images, lamp.fringes, as_it_is);
  std::vector<CameraDecode> decodes{whole};
  take_noise_free_coordinates(lamp.fringes, {lamp.images}, {lamp.options}, cloud, fits, 0.0, decodes);
  double worst_px = 0.0, flicker_px = 0.0;
  for (int y = kY0; y < kY0 + kSide; ++y)
    for (int x = kX0; x < kX0 + kSide; ++x) {
      const double truth_px = lamp.scene.column_px(x, y);
      worst_px = std::max(worst_px, std::abs(decodes[0].directions[0].coordinate_px(x, y) - truth_px));
      flicker_px = std::max(flicker_px, std::abs(flickers.directions[0].coordinate_px(x, y) - truth_px));
    }
  EXPECT_GT(flicker_px, 0.01);
  EXPECT_LT(worst_px, 1e-4);
  EXPECT_FALSE(std::isfinite(decodes[0].directions[0].coordinate_px(kX0 - 40, kY0)));
}

}  // namespace
}  // namespace fringetwin::measure::noise_free_coordinates_test
