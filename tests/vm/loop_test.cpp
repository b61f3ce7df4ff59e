// SPDX-License-Identifier: Apache-2.0
// Patterns through the kernel's driver and back, bit for bit; two cameras at once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tests/vm/vivid.hpp"

namespace fringetwin::testing::loop_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;

constexpr auto timeout = 2000ms;

// FRINGETWIN_VM_WRONG: expects one pixel one step off, to show that these tests can fail.
ImageU16 expected_dn(const ImageF& levels, int bits) {
  ImageU16 dn = quantise_levels(levels, bits);
  if (std::getenv("FRINGETWIN_VM_WRONG") != nullptr) dn(640, 360) ^= 1;
  return dn;
}

class VividLoop : public ::testing::TestWithParam<PixelFormat> {};

// The output goes on to a picture at one of its ticks; the capture's tick after that copies it. Both run at
// the same rate, so that a frame stamped a period later has it.
TEST_P(VividLoop, EveryPatternComesBackBitForBit) {
  const Vivid vivid(0);
  V4l2Display display(vivid.display(GetParam()));
  V4l2Camera camera(vivid.camera(GetParam()));
  const CameraInfo info = camera.info();
  ASSERT_EQ(info.width, vivid_width);
  ASSERT_EQ(info.height, vivid_height);
  ASSERT_EQ(info.bit_depth, traits(GetParam()).bit_depth);
  ASSERT_TRUE(display.info().timed);
  camera.start();
  const Fringes fringes = vivid_fringes();
  std::optional<std::uint32_t> last;
  int lost = 0, exact = 0;
  for (const Pattern& pattern : sequence_patterns(fringes)) {
    const ImageF levels = pattern_levels(fringes, pattern, vivid_width, vivid_height);
    const ImageU16 expected = expected_dn(levels, info.bit_depth);
    const Shown shown = display.show(pattern, levels);
    Frame frame;
    do {
      frame = camera.next_frame(timeout, CameraDevice::Pixels::keep);
      ASSERT_EQ(frame.fault, FrameFault::none);
      if (last) lost += static_cast<int>(frame.sequence - *last) - 1;
      last = frame.sequence;
    } while (static_cast<double>(frame.timestamp_ns - shown.at_ns) < vivid_period_ns);
    exact += frame.dn.data == expected.data;
  }
  std::printf("%s: %d of 8 exact, %d lost\n", traits(GetParam()).name, exact, lost);
  EXPECT_EQ(exact, 8);
  EXPECT_EQ(lost, 0);
}

INSTANTIATE_TEST_SUITE_P(Formats, VividLoop,
                         ::testing::Values(PixelFormat::grey, PixelFormat::y10, PixelFormat::y12,
                                           PixelFormat::y16, PixelFormat::y16_be, PixelFormat::yuyv),
                         [](const auto& each) {
                           std::string name = traits(each.param).name;
                           std::erase(name, '-');
                           return name;
                         });

TEST(VividTwo, SkewIsSteadyAndNothingIsLost) {
  const Vivid first(0), second(1);
  V4l2Camera cameras[] = {V4l2Camera(first.camera()), V4l2Camera(second.camera())};
  for (V4l2Camera& camera : cameras) camera.start();
  constexpr int frames = 40;
  std::vector<TimeNs> stamps[2];
  std::uint32_t sequence[2] = {};
  for (int i = 0; i < frames; ++i)
    for (int c = 0; c < 2; ++c) {
      const Frame frame = cameras[c].next_frame(timeout, CameraDevice::Pixels::drop);
      EXPECT_TRUE(i == 0 || frame.sequence == sequence[c] + 1) << "camera " << c;
      sequence[c] = frame.sequence;
      stamps[c].push_back(frame.timestamp_ns);
    }
  double least = 1e9, most = -1e9;
  for (int i = 0; i < frames; ++i) {
    const double skew_ms = 1e-6 * static_cast<double>(stamps[1][i] - stamps[0][i]);
    least = std::min(least, skew_ms);
    most = std::max(most, skew_ms);
  }
  std::printf("two cameras: skew %.3f to %.3f ms\n", least, most);
  // Each on a clock of the same rate, whose stamps fall on ticks of the kernel (4 ms), early or late by one.
  EXPECT_LT(most - least, 16.0);
  EXPECT_LT(std::max(std::abs(least), std::abs(most)), 1e-6 * vivid_period_ns);
}

TEST(VividControls, AutomaticGainIsOffAndGainReadBack) {
  const Vivid vivid(0);
  V4l2CameraOptions options = vivid.camera();
  options.gain = 77;
  options.controls = {{"Brightness", "100"}};
  const V4l2Camera camera(options);
  const CameraInfo info = camera.info();
  EXPECT_EQ(info.provenance.at("control.gain_automatic"), "0");
  EXPECT_EQ(info.provenance.at("control.gain"), "77");
  EXPECT_EQ(info.provenance.at("control.brightness"), "100");
  EXPECT_EQ(info.provenance.at("driver"), "vivid");
  EXPECT_FALSE(camera.exposure_range());
  for (const auto& [key, value] : info.provenance) std::printf("  %s = %s\n", key.c_str(), value.c_str());
}

TEST(VividControls, WhatTheDriverDoesNotTakeIsRefusedInOneSentence) {
  const Vivid vivid(0);
  const auto said = [&](const auto& change) -> std::string {
    V4l2CameraOptions options = vivid.camera();
    change(options);
    try {
      const V4l2Camera camera(options);
      return "nothing";
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::device);
      return error.what();
    }
  };
  EXPECT_EQ(said([](V4l2CameraOptions& o) { o.gain = 256; }),
            "/dev/video0: control 'gain' was asked for 256 which is out of range; it takes 0...255");
  EXPECT_THAT(said([](V4l2CameraOptions& o) {
                o.controls = {{"gian", "1"}};
              }),
              ::testing::HasSubstr("has no control 'gian'; it has"));
  EXPECT_THAT(said([](V4l2CameraOptions& o) { o.format.width = 640; }), ::testing::HasSubstr("not 640x720"));
  EXPECT_THAT(said([](V4l2CameraOptions& o) { o.format.format = PixelFormat::mjpg; }),
              ::testing::HasSubstr("does not offer MJPG; it offers"));
  EXPECT_THAT(said([](V4l2CameraOptions& o) { o.device = "/dev/video1"; }),
              ::testing::HasSubstr("has no video capture"));
  EXPECT_THAT(said([](V4l2CameraOptions& o) { o.device = "/dev/video99"; }),
              ::testing::HasSubstr("No such file"));
}

TEST(VividTimeStamps, StartOfExposureIsSeen) {
  Vivid vivid(0);
  V4l2Camera camera(vivid.camera());
  camera.start();
  EXPECT_FALSE(camera.info().timestamp_at_exposure_start);
  camera.stop();
  vivid.set("timestamp_source", 1);
  camera.start();
  camera.next_frame(timeout, CameraDevice::Pixels::drop);
  EXPECT_TRUE(camera.info().timestamp_at_exposure_start);
  camera.stop();
  vivid.set("timestamp_source", 0);
}

}  // namespace
}  // namespace fringetwin::testing::loop_test
