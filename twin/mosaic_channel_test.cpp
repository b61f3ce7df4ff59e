// SPDX-License-Identifier: Apache-2.0
// One colour of a colour sensor: which pixels it has, and where they look.
//
// | check                        | tolerance | origin                                                      |
// |------------------------------|-----------|-------------------------------------------------------------|
// | which pixels                 | exact     | counted by hand from the four letters                       |
// | places by the image's lens   | 1e-9 px   | those of the sensor's own lens, to which libmrcal iterates  |
// | lens of the sensor, and back | 1e-12     | rounding of a halved and doubled number                     |
#include "twin/mosaic_channel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/twin/random_lenses.hpp"

namespace fringetwin::mosaic_channel_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr MosaicColour kColours[] = {MosaicColour::red, MosaicColour::green, MosaicColour::green2,
                                     MosaicColour::blue};

TEST(MosaicChannel, PixelsOfEachColour) {
  const auto first = [](const char* mosaic, MosaicColour colour) {
    return MosaicChannel{mosaic, colour, {8, 6}}.first_px();
  };
  EXPECT_EQ(first("RGGB", MosaicColour::red), Vector2i(0, 0));
  EXPECT_EQ(first("RGGB", MosaicColour::green), Vector2i(1, 0));
  EXPECT_EQ(first("RGGB", MosaicColour::green2), Vector2i(0, 1));
  EXPECT_EQ(first("RGGB", MosaicColour::blue), Vector2i(1, 1));
  EXPECT_EQ(first("BGGR", MosaicColour::red), Vector2i(1, 1));
  EXPECT_EQ(first("GRBG", MosaicColour::green), Vector2i(0, 0));
  EXPECT_EQ(first("GRBG", MosaicColour::red), Vector2i(1, 0));
  EXPECT_EQ(first("GRBG", MosaicColour::green2), Vector2i(1, 1));
  EXPECT_EQ(first("GBRG", MosaicColour::blue), Vector2i(1, 0));
  EXPECT_EQ(first("GBRG", MosaicColour::red), Vector2i(0, 1));
}

TEST(MosaicChannel, FourColoursAreTheWholeSensor) {
  for (const std::string& mosaic : mosaic_names())
    for (const Vector2i& size : {Vector2i(8, 6), Vector2i(7, 5), Vector2i(2, 2), Vector2i(3, 2)}) {
      Image<int> sensor(size.x(), size.y());
      for (std::size_t i = 0; i < sensor.size(); ++i) sensor.data[i] = static_cast<int>(i);
      std::vector<int> seen;
      for (const MosaicColour colour : kColours) {
        const MosaicChannel channel{mosaic, colour, size};
        const Image<int> image = channel_image(sensor, channel);
        EXPECT_EQ(Vector2i(image.width, image.height), channel.image_px());
        seen.insert(seen.end(), image.data.begin(), image.data.end());
      }
      EXPECT_THAT(seen, ::testing::UnorderedElementsAreArray(sensor.data))
          << mosaic << ' ' << size.transpose();
    }
}

/// Expects that a pixel of the channel's image looks where that pixel of the whole sensor does.
void expect_same_directions(const Lens& sensor, const MosaicChannel& channel) {
  const Lens image = image_lens(sensor, channel, "test");
  EXPECT_EQ(Vector2i(image.width(), image.height()), channel.image_px());
  for (int y = 0; y < image.height(); y += image.height() / 4)
    for (int x = 0; x < image.width(); x += image.width() / 4) {
      const Vector2d on_sensor(channel.first_px().x() + 2 * x, channel.first_px().y() + 2 * y);
      EXPECT_EQ(sensor_place_px(channel, Vector2d(x, y)), on_sensor);
      EXPECT_EQ(image_place_px(channel, on_sensor), Vector2d(x, y));
      const auto of_sensor = sensor.unproject(on_sensor), of_image = image.unproject(Vector2d(x, y));
      ASSERT_EQ(of_sensor.has_value(), of_image.has_value());
      if (!of_sensor) continue;
      const auto back = image.project(*of_sensor);
      ASSERT_TRUE(back);
      EXPECT_LT((*back - Vector2d(x, y)).norm(), 1e-9) << sensor.model();
      EXPECT_LT((*of_sensor - *of_image).norm(), 1e-9);
    }
}

/// Expects every number of the sensor's lens back.
void expect_same_lens(const Lens& lens, const Lens& back) {
  EXPECT_EQ(back.model(), lens.model());
  EXPECT_EQ(back.width(), lens.width());
  EXPECT_EQ(back.height(), lens.height());
  for (std::size_t i = 0; i < lens.intrinsics().size(); ++i)
    EXPECT_NEAR(back.intrinsics()[i], lens.intrinsics()[i], 1e-12 * (1.0 + std::abs(lens.intrinsics()[i])));
}

RC_GTEST_PROP(MosaicChannel, LooksWhereTheSensorsPixelsDo, ()) {
  const Lens sensor = testing::any_lens();
  const MosaicChannel channel{*rc::gen::elementOf(mosaic_names()),
                              *rc::gen::element(kColours[0], kColours[1], kColours[2], kColours[3]),
                              {sensor.width(), sensor.height()}};
  expect_same_directions(sensor, channel);
  expect_same_lens(sensor, sensor_lens(image_lens(sensor, channel, "test"), channel));
}

// Models that only libmrcal knows: their knots and axes are of directions, too.
TEST(MosaicChannel, LensesOfLibmrcal) {
  std::vector<double> spline{900, 902, 365.7, 261.9};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.002, 0.002);
  for (int i = 0; i < 2 * 11 * 8; ++i) spline.push_back(uniform(random));
  for (const Lens& sensor :
       {Lens("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=8_fov_x_deg=60", spline, {720, 540}, "test"),
        Lens("LENSMODEL_CAHVOR", {1500, 1502, 640, 470, 0.01, -0.02, 0.003, 0.1, -0.05}, {1280, 960}, "test"),
        Lens("LENSMODEL_LATLON", {700, 700, 640, 470}, {1280, 960}, "test")})
    for (const MosaicColour colour : kColours)
      expect_same_directions(sensor, {"GRBG", colour, {sensor.width(), sensor.height()}});
}

TEST(MosaicChannel, Names) {
  for (const MosaicColour colour : kColours) EXPECT_EQ(mosaic_colour(name_of(colour)), colour);
  EXPECT_EQ(name_of(MosaicColour::green2), "green2");
  EXPECT_EQ(text_of({"GRBG", MosaicColour::blue, {8, 6}}), "blue of GRBG");
  EXPECT_FALSE(mosaic_colour("grey"));
}

}  // namespace
}  // namespace fringetwin::mosaic_channel_test
