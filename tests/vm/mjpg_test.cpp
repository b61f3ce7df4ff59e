// SPDX-License-Identifier: Apache-2.0
// Motion JPEG through the kernel (v4l2loopback): whole and damaged pictures of one stream.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <cstdio>
#include <memory>

#include "capture/device/pattern.hpp"
#include "capture/v4l2/v4l2_camera.hpp"
#include "tests/vm/vivid.hpp"

namespace fringetwin::testing::mjpg_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;

constexpr const char* loopback = "/dev/video20";
constexpr auto timeout = 2000ms;

using Bytes = std::vector<std::byte>;

Bytes jpeg_of(const ImageU16& dn) {
  std::vector<unsigned char> grey(dn.data.begin(), dn.data.end());
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  const int result = tjCompress2(encoder.get(), grey.data(), dn.width, 0, dn.height, TJPF_GRAY, &data, &size,
                                 TJSAMP_GRAY, 100, TJFLAG_ACCURATEDCT);
  if (result != 0) throw std::runtime_error(tjGetErrorStr2(encoder.get()));
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  Bytes jpeg(bytes, bytes + size);
  tjFree(data);
  return jpeg;
}

// Plays what a camera would send.
class Producer {
 public:
  Producer() : device_(kernel_v4l2(), loopback, V4L2_CAP_VIDEO_OUTPUT) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = vivid_width;
    format.fmt.pix.height = vivid_height;
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_MJPEG;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.sizeimage = vivid_width * vivid_height;
    if (const int result = device_.call(VIDIOC_S_FMT, format); result != 0)
      throw device_.refusal(error_text(result));
  }
  void send(const Bytes& jpeg) {
    if (write(device_.fd(), jpeg.data(), jpeg.size()) != static_cast<ssize_t>(jpeg.size()))
      throw device_.refusal("does not take a picture");
  }

 private:
  V4l2Device device_;
};

TEST(LoopbackMjpg, WholePicturesAreDecodedAndDamagedOnesTold) {
  Producer producer;
  const Fringes fringes = vivid_fringes();
  std::vector<Bytes> jpegs;
  for (const Pattern& pattern : sequence_patterns(fringes))
    jpegs.push_back(jpeg_of(quantise_levels(pattern_levels(fringes, pattern, vivid_width, vivid_height), 8)));
  producer.send(jpegs[0]);  // the driver has no format for a reader before
  V4l2CameraOptions options;
  options.device = loopback;
  options.format = {PixelFormat::mjpg, vivid_width, vivid_height, std::nullopt, 0};
  V4l2Camera camera(options);
  camera.start();
  camera.drain();
  const FrameLayout layout{PixelFormat::mjpg, vivid_width, vivid_height, 0, 0, 0};
  int exact = 0, told = 0;
  std::size_t largest = 0;
  for (std::size_t i = 0; i < 2 * jpegs.size(); ++i) {
    const Bytes& whole = jpegs[i % jpegs.size()];
    const bool damaged = i % 3 == 2;
    producer.send(damaged
                      ? Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2))
                      : whole);
    const Frame frame = camera.next_frame(timeout, CameraDevice::Pixels::keep);
    largest = std::max(largest, whole.size());
    if (damaged)
      told += frame.fault == FrameFault::undecodable && frame.dn.empty();
    else
      exact += frame.fault == FrameFault::none && frame.dn.data == unpack_frame(whole, layout).dn.data;
  }
  const CameraInfo info = camera.info();
  std::printf("MJPG: %d of 11 exact, %d of 5 damaged ones told, up to %zu bytes; time stamps: %s\n", exact,
              told, largest, info.provenance.at("time_stamps").c_str());
  EXPECT_EQ(exact, 11);
  EXPECT_EQ(told, 5);
  EXPECT_EQ(info.provenance.at("format"), "MJPG");
  EXPECT_EQ(info.provenance.at("driver"), "v4l2 loopback");
}

}  // namespace
}  // namespace fringetwin::testing::mjpg_test
