// SPDX-License-Identifier: Apache-2.0
// One colour of a colour camera: which pixels of which device, and what is refused. All exact: integers.
#include "capture/device/channel_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "capture/genicam/genicam_camera.hpp"
#include "capture/v4l2/v4l2_camera.hpp"
#include "tests/support/capture/fake_genicam.hpp"
#include "tests/support/capture/fake_v4l2.hpp"
#include "tests/support/twin/expect_user_error.hpp"

namespace fringetwin::testing::channel_camera_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;
using ::testing::ElementsAre;

const Eigen::Vector2i kSensorPx{4, 2};

/// A driver of a colour sensor of 4 x 2 px, which offers monochrome values made up from it, too.
std::shared_ptr<FakeV4l2> colour_driver() {
  auto driver = std::make_shared<FakeV4l2>();
  driver->formats = {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_SRGGB8, V4L2_PIX_FMT_SGBRG8};
  driver->sizes = {{4, 2}};
  std::vector<std::byte> bytes;
  for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::byte>(10 + i));
  driver->frames.push_back({bytes, 3, 5'000'000});
  return driver;
}

std::unique_ptr<CameraDevice> v4l2_camera(const std::string& mosaic, std::optional<PixelFormat> format = {}) {
  V4l2CameraOptions options;
  options.format.format = format;
  options.format.width = 4;
  options.format.height = 2;
  options.format.mosaic = mosaic;
  return std::make_unique<V4l2Camera>(options, colour_driver());
}

FakeGenicamState colour_camera() {
  FakeGenicamState state;
  state.features["PixelFormat"] =
      FakeGenicamState::choice("Mono8", {"Mono8", "BayerRG8", "BayerGB8", "BayerGB12"});
  return state;
}

std::unique_ptr<CameraDevice> genicam_camera(FakeGenicamState& state, const std::string& mosaic,
                                             const std::string& format = "") {
  GenicamCameraOptions options;
  options.width = 4;
  options.height = 2;
  options.mosaic = mosaic;
  options.format = format;
  return std::make_unique<GenicamCamera>(options, std::make_unique<FakeGenicamDevice>(state));
}

TEST(ChannelCamera, GivesThePixelsOfItsColour) {
  for (const auto& [colour, expected] :
       {std::pair{MosaicColour::red, std::array{10, 12}}, std::pair{MosaicColour::green, std::array{11, 13}},
        std::pair{MosaicColour::green2, std::array{14, 16}},
        std::pair{MosaicColour::blue, std::array{15, 17}}}) {
    ChannelCamera camera(v4l2_camera("RGGB"), {"RGGB", colour, kSensorPx});
    const CameraInfo info = camera.info();
    EXPECT_EQ(info.width, 2);
    EXPECT_EQ(info.height, 1);
    EXPECT_EQ(info.provenance.at("format"), "SRGGB8");
    EXPECT_EQ(info.provenance.at("mosaic"), "RGGB");
    EXPECT_EQ(info.provenance.at("channel"), name_of(colour) + " of RGGB");
    camera.start();
    const Frame frame = camera.next_frame(20ms, CameraDevice::Pixels::keep);
    EXPECT_EQ(frame.sequence, 3u);
    EXPECT_THAT(frame.dn.data, ElementsAre(expected[0], expected[1]));
  }
  ChannelCamera camera(v4l2_camera("RGGB"), {"RGGB", MosaicColour::red, kSensorPx});
  camera.start();
  EXPECT_TRUE(camera.next_frame(20ms, CameraDevice::Pixels::drop).dn.empty());
}

TEST(ChannelCamera, AnotherSizeIsRefused) {
  expect_user_error(
      ExitCode::device,
      "/dev/video0: delivers 4 x 2 px, the whole colour sensor of the twin has 4 x 4; check imagersize", [] {
        ChannelCamera(v4l2_camera("RGGB"), {"RGGB", MosaicColour::red, {4, 4}});
      });
}

TEST(ChannelCamera, VideoDevicesGiveTheTwinsMosaicOrSayThatTheyDoNot) {
  EXPECT_EQ(v4l2_camera("")->info().provenance.at("format"), "GREY");
  EXPECT_FALSE(v4l2_camera("")->info().provenance.contains("mosaic"));
  EXPECT_EQ(v4l2_camera("GBRG")->info().provenance.at("format"), "SGBRG8");
  EXPECT_EQ(v4l2_camera("", PixelFormat::sgbrg8)->info().provenance.at("mosaic"), "GBRG");
  expect_user_error(ExitCode::device,
                    "/dev/video0: offers none of SBGGR16, SBGGR14, SBGGR12, SBGGR10, SBGGR8; it offers GREY, "
                    "SRGGB8, SGBRG8",
                    [] { v4l2_camera("BGGR"); });
  expect_user_error(ExitCode::device, "gives GREY, the twin's sensor is a mosaic RGGB",
                    [] { v4l2_camera("RGGB", PixelFormat::grey); });
  expect_user_error(ExitCode::device, "gives SGBRG8, the twin's sensor is a mosaic RGGB",
                    [] { v4l2_camera("RGGB", PixelFormat::sgbrg8); });
}

TEST(ChannelCamera, GenicamCamerasGiveTheTwinsMosaicOrSayThatTheyDoNot) {
  FakeGenicamState state = colour_camera();
  EXPECT_EQ(genicam_camera(state, "")->info().provenance.at("format"), "Mono8");
  EXPECT_EQ(genicam_camera(state, "RGGB")->info().provenance.at("format"), "BayerRG8");
  EXPECT_EQ(genicam_camera(state, "GBRG")->info().provenance.at("format"), "BayerGB8");  // the twin's 8 bits
  EXPECT_EQ(genicam_camera(state, "", "BayerGB8")->info().provenance.at("mosaic"), "GB");
  expect_user_error(ExitCode::device, "offers no format of the mosaic BGGR that the twin's sensor has",
                    [&] { genicam_camera(state, "BGGR"); });
  expect_user_error(ExitCode::device, "gives Mono8, the twin's sensor is a mosaic RGGB",
                    [&] { genicam_camera(state, "RGGB", "Mono8"); });
  expect_user_error(ExitCode::device, "gives BayerGB8, the twin's sensor is a mosaic RGGB",
                    [&] { genicam_camera(state, "RGGB", "BayerGB8"); });
  state.features["PixelFormat"].choices = {"BayerGB8"};
  expect_user_error(ExitCode::device, "a twin of a colour sensor says mosaic and channel in [camera.sensor]",
                    [&] { genicam_camera(state, ""); });
}

}  // namespace
}  // namespace fringetwin::testing::channel_camera_test
