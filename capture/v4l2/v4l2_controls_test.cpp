// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_controls.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "capture/v4l2/v4l2_camera.hpp"
#include "tests/support/capture/fake_v4l2.hpp"

namespace fringetwin::testing::v4l2_controls_test {
namespace {

using namespace fringetwin::capture;
using ::testing::HasSubstr;

struct Bench {
  std::shared_ptr<FakeV4l2> driver = std::make_shared<FakeV4l2>();
  V4l2CameraOptions options;
  Bench() { add_camera_controls(*driver); }
  V4l2Camera camera() const { return V4l2Camera(options, driver); }
  std::int64_t value(std::uint32_t id) const { return driver->control(id).value; }
  std::string refusal() const {
    try {
      camera();
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::device);
      return error.what();
    }
    return "none";
  }
};

TEST(V4l2Controls, WhateverIsAutomaticIsOff) {
  const Bench bench;
  bench.camera();
  EXPECT_EQ(bench.value(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
  for (const std::uint32_t id : {V4L2_CID_EXPOSURE_AUTO_PRIORITY, V4L2_CID_AUTO_WHITE_BALANCE,
                                 V4L2_CID_AUTOGAIN, V4L2_CID_BACKLIGHT_COMPENSATION, V4L2_CID_FOCUS_AUTO})
    EXPECT_EQ(bench.value(id), 0) << id;
  EXPECT_EQ(bench.value(V4L2_CID_GAIN), 16);  // no automatic, left alone
}

TEST(V4l2Controls, AnAutomaticThatTheUserSetsStays) {
  Bench bench;
  bench.options.controls = {{"Focus, Automatic Continuous", "on"}};
  bench.camera();
  EXPECT_EQ(bench.value(V4L2_CID_FOCUS_AUTO), 1);
  EXPECT_EQ(bench.value(V4L2_CID_AUTOGAIN), 0);
}

TEST(V4l2Controls, AnAutomaticThatStaysOnIsAnError) {
  const Bench bench;
  bench.driver->control(V4L2_CID_AUTOGAIN).stuck = true;
  EXPECT_EQ(bench.refusal(),
            "/dev/video0: control 'gain_automatic' was asked for 0 but has 1; it takes 0 = off, 1 = on");
}

TEST(V4l2Controls, ExposureIsInHundredMicroseconds) {
  Bench bench;
  bench.options.exposure_ms = 12.0;
  V4l2Camera camera = bench.camera();
  EXPECT_EQ(bench.value(V4L2_CID_EXPOSURE_ABSOLUTE), 120);
  EXPECT_DOUBLE_EQ(*camera.exposure_ms(), 12.0);
  EXPECT_DOUBLE_EQ(camera.exposure_range()->min_ms, 1.0);
  EXPECT_DOUBLE_EQ(camera.exposure_range()->max_ms, 1000.0);
  EXPECT_DOUBLE_EQ(camera.exposure_range()->step_ms, 1.0);
  EXPECT_DOUBLE_EQ(camera.set_exposure_ms(15.4), 15.0);  // its steps are whole ms
  EXPECT_THROW(camera.set_exposure_ms(0.5), UserError);
  EXPECT_EQ(bench.value(V4L2_CID_EXPOSURE_ABSOLUTE), 150);
}

TEST(V4l2Controls, ExposureOutOfRangeOrNotTaken) {
  Bench bench;
  bench.options.exposure_ms = 2000.0;
  EXPECT_EQ(bench.refusal(),
            "/dev/video0: an exposure of 2000 ms was asked for, control 'exposure_time_absolute' has "
            "1...1000 ms");
  bench.options.exposure_ms = 20.0;
  bench.driver->control(V4L2_CID_EXPOSURE_ABSOLUTE).stuck = true;
  EXPECT_EQ(bench.refusal(),
            "/dev/video0: control 'exposure_time_absolute' was asked for 200 but has 150; it takes "
            "10...10000 in steps of 10");
}

// 1000 pixels and 600 of blanking at 160 MHz: a line takes 10 us.
TEST(V4l2Controls, ExposureInLinesOfASensor) {
  Bench bench;
  bench.driver->sizes = {{1000, 4}};
  bench.driver->controls = {
      {V4L2_CID_EXPOSURE, "Exposure", V4L2_CTRL_TYPE_INTEGER, 4, 2000, 1, 100},
      {V4L2_CID_HBLANK, "Horizontal Blanking", V4L2_CTRL_TYPE_INTEGER, 600, 600, 1, 600},
      {V4L2_CID_PIXEL_RATE, "Pixel Rate", V4L2_CTRL_TYPE_INTEGER64, 1, 200000000, 1, 160000000}};
  bench.options.exposure_ms = 7.0;
  const V4l2Camera camera = bench.camera();
  EXPECT_EQ(bench.value(V4L2_CID_EXPOSURE), 700);
  EXPECT_DOUBLE_EQ(*camera.exposure_ms(), 7.0);
}

TEST(V4l2Controls, ExposureWithoutAUnitIsNoTime) {
  Bench bench;
  bench.driver->controls = {{V4L2_CID_EXPOSURE, "Exposure", V4L2_CTRL_TYPE_INTEGER, 4, 2000, 1, 100}};
  EXPECT_FALSE(bench.camera().exposure_range());
  bench.options.exposure_ms = 7.0;
  EXPECT_EQ(bench.refusal(),
            "/dev/video0: has an exposure control in the driver's own unit, not in ms; set control "
            "'exposure' instead, it takes 4...2000");
  bench.options.exposure_ms.reset();
  bench.options.controls = {{"exposure", "50"}};
  bench.camera();
  EXPECT_EQ(bench.value(V4L2_CID_EXPOSURE), 50);
  bench.driver->controls.clear();
  bench.options = {};
  bench.options.exposure_ms = 7.0;
  EXPECT_THAT(bench.refusal(), HasSubstr("/dev/video0: has no exposure control"));
}

TEST(V4l2Controls, ValuesByNumberAndByName) {
  Bench bench;
  bench.options.controls = {
      {"auto_exposure", "aperture priority mode"}, {"gain_automatic", "true"}, {"GAIN", "9"}};
  bench.camera();
  EXPECT_EQ(bench.value(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(bench.value(V4L2_CID_AUTOGAIN), 1);
  EXPECT_EQ(bench.value(V4L2_CID_GAIN), 9);
}

TEST(V4l2Controls, WhatCannotBeSetIsSaidInOneSentence) {
  const auto said = [](const std::string& name, const std::string& value, const auto& change) {
    Bench bench;
    bench.options.controls = {{name, value}};
    change(*bench.driver);
    return bench.refusal();
  };
  const auto nothing = [](FakeV4l2&) {};
  EXPECT_EQ(said("gain", "256", nothing),
            "/dev/video0: control 'gain' was asked for 256 which is out of range; it takes 0...255");
  EXPECT_EQ(said("gain", "much", nothing), "/dev/video0: control 'gain' cannot be 'much'; it takes 0...255");
  EXPECT_EQ(said("auto_exposure", "2", nothing),
            "/dev/video0: control 'auto_exposure' was asked for 2 which is out of range; it takes 1 = Manual "
            "Mode, 3 = "
            "Aperture Priority Mode");
  EXPECT_THAT(
      said("zoom", "2", nothing),
      HasSubstr("/dev/video0: has no control 'zoom'; it has white_balance_automatic, gain_automatic, "));
  EXPECT_EQ(said("gain", "7", [](FakeV4l2& d) { d.control(V4L2_CID_GAIN).flags = V4L2_CTRL_FLAG_READ_ONLY; }),
            "/dev/video0: control 'gain' was asked for 7 but can only be read; it takes 0...255");
  EXPECT_EQ(
      said("gain", "7", [](FakeV4l2& d) { d.errors[VIDIOC_S_EXT_CTRLS] = {0, 0, 0, 0, 0, 0, -EIO}; }),
      "/dev/video0: control 'gain' was asked for 7 and refused it: Input/output error; it takes 0...255");
}

TEST(V4l2Controls, AllValuesAreRecorded) {
  Bench bench;
  bench.options.gain = 33;
  const auto provenance = bench.camera().info().provenance;
  EXPECT_EQ(provenance.at("control.gain"), "33");
  EXPECT_EQ(provenance.at("control.auto_exposure"), "1 (Manual Mode)");
  V4l2Camera camera = bench.camera();
  camera.set_exposure_ms(40.0);
  EXPECT_EQ(camera.info().provenance.at("control.exposure_time_absolute"), "400");
}

}  // namespace
}  // namespace fringetwin::testing::v4l2_controls_test
