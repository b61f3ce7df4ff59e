// SPDX-License-Identifier: Apache-2.0
// | tolerance | origin |
// |---|---|
// | none | counts of whole gray values |
#include "cosim/brightness.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace fringetwin::cosim::brightness_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Twin three_steps(double gain_dn, double black_level_dn) {
  Twin twin;
  const Lens lens("LENSMODEL_PINHOLE", {900, 905, 31.5, 23.5}, {64, 48}, "test");
  twin.cameras = {{"left", lens, Pose{}, Sensor{}, std::nullopt}};
  twin.cameras[0].sensor.gain_dn = gain_dn;
  twin.cameras[0].sensor.black_level_dn = black_level_dn;
  twin.fringes.steps = 3;
  twin.fringes.directions = {{Axis::x, {13}, {0}, {}}};
  return twin;
}

/// Three images of 100 x 100 pixels, dark but for 1 % of the pixels; one in 10 000 is hot.
std::vector<CameraImages> peaking_at(double dn) {
  CameraImages images{.camera = "left"};
  for (int k = 0; k < 3; ++k) {
    ImageF image(100, 100, 2.0F);
    for (int x = 0; x < 100; ++x) image(x, 50) = static_cast<float>(dn);
    image(3, 3) = 255.0F;
    images.images.push_back(std::move(image));
  }
  return {images};
}

TEST(Brightness, ThePeakIsThatOfASmallPartAndOfNoHotPixel) {
  EXPECT_EQ(peak_dn(three_steps(1, 0), peaking_at(232)[0]), 232.0);
  EXPECT_EQ(peak_dn(three_steps(1, 0), peaking_at(10)[0]), 10.0);
  EXPECT_TRUE(std::isnan(peak_dn(three_steps(1, 0), CameraImages{})));
}

// (232 - 2) / (10 - 2) = 28.75 times the gain of 2.
TEST(Brightness, SaysPeaksAndTheGainThatFits) {
  EXPECT_THAT(
      brightness_warnings(three_steps(2, 2), peaking_at(232), peaking_at(10)),
      ElementsAre("left: images peak at 10 DN, the real ones at 232: thresholds, noise and saturation "
                  "are not those of the rig; [camera.sensor] gain_dn = 57.5 in place of 2 would make "
                  "them alike"));
  EXPECT_THAT(
      brightness_warnings(three_steps(2, 0), peaking_at(50), peaking_at(200)),
      ElementsAre("left: images peak at 200 DN, the real ones at 50: thresholds, noise and saturation "
                  "are not those of the rig; [camera.sensor] gain_dn = 0.5 in place of 2 would make "
                  "them alike"));
}

TEST(Brightness, NothingIsSaidWithinAFactorOfTwoOrWithoutGrayValues) {
  EXPECT_THAT(brightness_warnings(three_steps(2, 0), peaking_at(200), peaking_at(101)), IsEmpty());
  EXPECT_THAT(brightness_warnings(three_steps(2, 0), peaking_at(101), peaking_at(200)), IsEmpty());
  EXPECT_THAT(brightness_warnings(three_steps(2, 0), {}, peaking_at(200)), IsEmpty());
  std::vector<CameraImages> irradiance = peaking_at(10);
  irradiance[0].radiance = true;
  EXPECT_THAT(brightness_warnings(three_steps(2, 0), irradiance, peaking_at(200)), IsEmpty());
}

}  // namespace
}  // namespace fringetwin::cosim::brightness_test
