// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_display.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "tests/support/capture/fake_v4l2.hpp"

namespace fringetwin::testing::v4l2_display_test {
namespace {

using namespace fringetwin::capture;

std::shared_ptr<FakeV4l2> output(std::size_t held) {
  auto driver = std::make_shared<FakeV4l2>();
  driver->caps = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  driver->formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_Y10, V4L2_PIX_FMT_GREY};
  driver->held = held;
  return driver;
}

V4l2DisplayOptions options() {
  V4l2DisplayOptions options;
  options.device = "/dev/video0";
  return options;
}

// One picture after the other, though some devices give an old one back for two new ones only.
TEST(V4l2Display, PicturesFollowEachOtherWhateverTheDeviceKeeps) {
  for (const std::size_t held : {1u, 2u, 3u}) {
    const auto driver = output(held);
    V4l2Display display(options(), driver);
    EXPECT_EQ(display.info().bit_depth, 10);
    EXPECT_EQ(display.info().width, 8);
    EXPECT_TRUE(display.info().timed);
    TimeNs last = -1;
    for (const double level : {0.25, 1.0, 0.5}) {
      const Shown shown = display.show(even_field(level, "field"), ImageF(8, 4, static_cast<float>(level)));
      EXPECT_TRUE(shown.timed);
      EXPECT_GT(shown.at_ns, last);
      last = shown.at_ns;
      const auto value = static_cast<std::uint16_t>(std::lround(level * 1023));
      FrameLayout layout{PixelFormat::y10, 8, 4, 16, 64, 0};
      EXPECT_EQ(unpack_frame(driver->played.back(), layout).dn.data, std::vector<std::uint16_t>(32, value));
    }
  }
}

TEST(V4l2Display, FaultsOfTheDevice) {
  const auto kind = [](const auto& change) -> std::optional<DeviceFault::Kind> {
    const auto driver = output(1);
    V4l2Display display(options(), driver);
    change(*driver);
    try {
      display.show(even_field(1.0, "white"), ImageF(8, 4, 1.0f));
    } catch (const DeviceFault& fault) {
      return fault.kind();
    }
    return std::nullopt;
  };
  EXPECT_EQ(kind([](FakeV4l2&) {}), std::nullopt);
  EXPECT_EQ(kind([](FakeV4l2& d) { d.gone = true; }), DeviceFault::Kind::gone);
  EXPECT_EQ(kind([](FakeV4l2& d) { d.errors[VIDIOC_QBUF] = {-EIO}; }), DeviceFault::Kind::stream);
  EXPECT_EQ(kind([](FakeV4l2& d) { d.errors[VIDIOC_DQBUF] = {-EIO}; }), DeviceFault::Kind::stream);
}

TEST(V4l2Display, ACameraIsRefused) {
  EXPECT_THROW(V4l2Display(options(), std::make_shared<FakeV4l2>()), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::v4l2_display_test
