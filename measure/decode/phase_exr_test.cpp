// SPDX-License-Identifier: Apache-2.0
// Channel names and NaN are exact; values are the float32 of the decode.
#include "measure/decode/phase_exr.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "tests/support/measure/synthetic_fringes.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::measure::phase_exr_test {
namespace {

TEST(PhaseExr, ChannelNamesPrintThePitchShortest) {
  EXPECT_EQ(wrapped_channel_name(Axis::x, 13.0), "wrapped_x_13");
  EXPECT_EQ(wrapped_channel_name(Axis::y, 13.5), "wrapped_y_13p5");
  EXPECT_EQ(wrapped_channel_name(Axis::x, 0.1), "wrapped_x_0p1");
  EXPECT_EQ(wrapped_channel_name(Axis::x, 1e20), "wrapped_x_100000000000000000000");
  EXPECT_EQ(wrapped_channel_name(Axis::x, 1e-7), "wrapped_x_0p0000001");
}

TEST(PhaseExr, TwoDirectionsRoundTrip) {
  Fringes f = testing::one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  f.directions.push_back(f.directions[0]);
  f.directions[1].axis = Axis::y;
  f.directions[1].pitches_px = {13.5, 14.5, 15.5};
  testing::FringeScene scene;
  scene.column_px = testing::ramp(40, 30, 10.0, 400.0);
  scene.row_px = testing::ramp(40, 30, 100.0, 300.0, 50.0);
  scene.albedo = ImageF(40, 30, 1.0f);
  scene.albedo(3, 4) = 0.0f;  // unlit pixel
  CameraDecode decoded = decode(testing::project(f, scene), f, {});
  decoded.camera = "left eye";
  const auto dir = std::filesystem::temp_directory_path() / "fringetwin_phase_exr_test";
  std::filesystem::create_directories(dir);
  write_phase_exr(dir, decoded);

  std::map<std::string, ImageF> read;
  for (auto& [name, image] : read_exr(dir / "phase_left eye.exr")) read[name] = image;
  std::filesystem::remove_all(dir);
  for (const char* name : {"wrapped_x_13", "wrapped_x_14", "wrapped_x_15", "wrapped_y_13p5", "wrapped_y_14p5",
                           "wrapped_y_15p5", "column_px", "row_px", "amplitude_dn", "mean_dn", "sigma_rad",
                           "amplitude_dn_y", "mean_dn_y", "sigma_rad_y"})
    ASSERT_TRUE(read.count(name)) << name;
  EXPECT_EQ(read.size(), 14u);
  for (const auto& [name, image] : read) EXPECT_TRUE(std::isnan(image(3, 4))) << name;
  for (std::size_t i = 0; i < scene.column_px.size(); ++i) {
    const auto expected = static_cast<float>(decoded.directions[0].coordinate_px.data[i]);
    if (std::isfinite(expected)) {
      ASSERT_EQ(read["column_px"].data[i], expected);
    }
  }
}

// Light of 10 ... 210 DN whose fringes have half of full contrast: mean 110 DN, modulation 50 DN, to float32.
TEST(PhaseExr, EachChannelHoldsWhatItsNameSays) {
  Fringes f = testing::one_direction(Unwrap::heterodyne, 4, {13, 14, 15}, {0, 0, 0});
  f.amplitude = 0.25;
  testing::FringeScene scene;
  scene.column_px = testing::ramp(40, 30, 10.0, 400.0);
  scene.quantised = false;
  const CameraDecode decoded = decode(testing::project(f, scene), f, {});
  std::map<std::string, ImageF> channels;
  for (const auto& [name, image] : phase_channels(decoded)) channels[name] = image;
  for (std::size_t i = 0; i < scene.column_px.size(); ++i) {
    ASSERT_TRUE(std::isfinite(channels["mean_dn"].data[i])) << i;
    ASSERT_NEAR(static_cast<double>(channels["mean_dn"].data[i]), 110.0, 1e-3);
    ASSERT_NEAR(static_cast<double>(channels["amplitude_dn"].data[i]), 50.0, 1e-3);
    ASSERT_EQ(channels["sigma_rad"].data[i], decoded.directions[0].sigma_rad.data[i]);
    ASSERT_EQ(channels["wrapped_x_14"].data[i], decoded.directions[0].wrapped_rad[1].data[i]);
  }
}

TEST(PhaseExr, WithoutUnwrappingThereIsNoCoordinate) {
  const Fringes f = testing::one_direction(Unwrap::none, 4, {20}, {0});
  testing::FringeScene scene;
  scene.column_px = testing::ramp(16, 8, 0.0, 100.0);
  const auto channels = phase_channels(decode(testing::project(f, scene), f, {}));
  ASSERT_EQ(channels.size(), 4u);
  EXPECT_EQ(channels[0].first, "wrapped_x_20");
  EXPECT_TRUE(std::isfinite(channels[3].second(5, 5)));  // sigma_rad
}

}  // namespace
}  // namespace fringetwin::measure::phase_exr_test
