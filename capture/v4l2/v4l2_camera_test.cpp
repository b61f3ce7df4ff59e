// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <random>

#include "capture/v4l2/v4l2_list.hpp"
#include "tests/support/capture/fake_v4l2.hpp"

namespace fringetwin::testing::v4l2_camera_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr auto timeout = 20ms;

struct Bench {
  std::shared_ptr<FakeV4l2> driver = std::make_shared<FakeV4l2>();
  V4l2CameraOptions options;
  Bench() { options.start_pause = 0ms; }

  void frame(std::uint32_t sequence, std::size_t length = 32,
             std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
    driver->frames.push_back({std::vector<std::byte>(length, static_cast<std::byte>(sequence)), sequence,
                              33'000 * static_cast<std::int64_t>(sequence) + 2'000'000, flags});
  }
  std::unique_ptr<V4l2Camera> camera() const { return std::make_unique<V4l2Camera>(options, driver); }
  std::unique_ptr<V4l2Camera> started() const {
    auto made = camera();
    made->start();
    return made;
  }
  std::string refusal() const {
    try {
      started();
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::device);
      return error.what();
    }
    return "none";
  }
};

Frame next(V4l2Camera& camera, CameraDevice::Pixels pixels = CameraDevice::Pixels::keep) {
  return camera.next_frame(timeout, pixels);
}

template <class Call>
std::optional<DeviceFault::Kind> fault_of(Call call) {
  try {
    call();
  } catch (const DeviceFault& fault) {
    return fault.kind();
  }
  return std::nullopt;
}

// --- frames

TEST(V4l2Frames, ComeInOrderWithWhatTheDriverSaysOfThem) {
  Bench bench;
  const auto camera = bench.started();
  for (const std::uint32_t sequence : {4u, 5u, 7u, 7u, 8u, 9u}) bench.frame(sequence);  // one lost, one twice
  std::vector<std::uint32_t> sequences;
  for (int i = 0; i < 6; ++i) {
    const Frame frame = next(*camera);
    sequences.push_back(frame.sequence);
    EXPECT_EQ(frame.timestamp_ns, 33'000'000LL * frame.sequence + 2'000'000'000LL);
    EXPECT_EQ(frame.fault, FrameFault::none);
    ASSERT_EQ(frame.dn.width, 8);
    ASSERT_EQ(frame.dn.height, 4);
    EXPECT_EQ(frame.dn(3, 2), frame.sequence);
  }
  EXPECT_THAT(sequences, ElementsAre(4, 5, 7, 7, 8, 9));
}

TEST(V4l2Frames, FaultyOnesAreToldAndTheStreamGoesOn) {
  Bench bench;
  const auto camera = bench.started();
  bench.frame(0, 32, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_ERROR);
  bench.frame(1, 31);
  bench.frame(2, 9999);  // more than the buffer holds
  bench.frame(3);
  std::vector<FrameFault> faults;
  for (int i = 0; i < 4; ++i) {
    const Frame frame = next(*camera);
    faults.push_back(frame.fault);
    EXPECT_EQ(frame.dn.empty(), frame.fault != FrameFault::none);
  }
  EXPECT_THAT(faults, ElementsAre(FrameFault::error_flag, FrameFault::wrong_length, FrameFault::wrong_length,
                                  FrameFault::none));
}

TEST(V4l2Frames, DroppedPixelsStillTellTheFault) {
  Bench bench;
  const auto camera = bench.started();
  bench.frame(0);
  bench.frame(1, 5);
  const Frame sound = next(*camera, CameraDevice::Pixels::drop);
  EXPECT_TRUE(sound.dn.empty());
  EXPECT_EQ(sound.fault, FrameFault::none);
  EXPECT_EQ(next(*camera, CameraDevice::Pixels::drop).fault, FrameFault::wrong_length);
}

TEST(V4l2Frames, ADamagedJpegIsUndecodable) {
  Bench bench;
  bench.driver->formats = {V4L2_PIX_FMT_MJPEG};
  const auto camera = bench.started();
  bench.frame(0, 500);
  EXPECT_EQ(next(*camera).fault, FrameFault::undecodable);
}

TEST(V4l2Frames, PaddedLines) {
  Bench bench;
  bench.driver->padding = 8;
  const auto camera = bench.started();
  FakeFrame frame{std::vector<std::byte>(16 * 4), 0, 0};
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < 16; ++x)
      frame.bytes[16 * y + x] = static_cast<std::byte>(x < 8 ? 10 * y + x : 255);
  bench.driver->frames.push_back(frame);
  const Frame got = next(*camera);
  ASSERT_EQ(got.fault, FrameFault::none);
  EXPECT_EQ(got.dn(7, 3), 37);
  EXPECT_EQ(got.dn(0, 1), 10);
}

TEST(V4l2Frames, OurOwnTimeWhereTheDriverHasNone) {
  Bench bench;
  bench.driver->buffer_flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  const auto camera = bench.started();
  bench.frame(0, 32, V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN);
  const TimeNs before = camera->now_ns();
  const Frame frame = next(*camera);
  EXPECT_GE(frame.timestamp_ns, before);
  EXPECT_LE(frame.timestamp_ns, camera->now_ns());
  EXPECT_THAT(camera->info().provenance.at("time_stamps"), HasSubstr("the driver gives none"));
}

TEST(V4l2Frames, StampsAtTheStartOfTheExposure) {
  Bench bench;
  bench.driver->buffer_flags |= V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  EXPECT_TRUE(bench.started()->info().timestamp_at_exposure_start);
  bench.driver->buffer_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  EXPECT_FALSE(bench.started()->info().timestamp_at_exposure_start);
}

TEST(V4l2Frames, DrainedOnesAreGone) {
  Bench bench;
  const auto camera = bench.started();
  for (std::uint32_t i = 0; i < 10; ++i) bench.frame(i);
  camera->drain();
  bench.frame(10);
  EXPECT_EQ(next(*camera).sequence, 10u);
}

// --- faults of the device

TEST(V4l2Faults, StartIsTriedAgainAndThenRefused) {
  for (const unsigned long request : {VIDIOC_REQBUFS, VIDIOC_QBUF, VIDIOC_STREAMON, VIDIOC_QUERYBUF}) {
    Bench bench;
    // stop() and release() ask for no buffers, too, which may fail as well
    const auto camera = bench.camera();
    bench.driver->errors[request] =
        request == VIDIOC_REQBUFS ? std::deque{0, -EINVAL} : std::deque{-EINVAL, -EINVAL};
    camera->start();
    EXPECT_EQ(camera->refused_starts(), request == VIDIOC_REQBUFS ? 1 : 2);
    bench.frame(0);
    EXPECT_EQ(next(*camera).fault, FrameFault::none);
    camera->stop();
    bench.driver->errors[request] = std::deque<int>(40, -EINVAL);
    EXPECT_THAT(bench.refusal(),
                HasSubstr("/dev/video0: does not start to stream after 4 tries: Invalid argument"));
    EXPECT_EQ(bench.driver->mapped, 0);
  }
}

TEST(V4l2Faults, KindsOfBreakage) {
  struct Case {
    unsigned long request;
    int error;
    DeviceFault::Kind kind;
  };
  for (const Case& c : {Case{VIDIOC_DQBUF, -EIO, DeviceFault::Kind::stream},
                        Case{VIDIOC_DQBUF, -ENODEV, DeviceFault::Kind::gone},
                        Case{VIDIOC_QBUF, -EINVAL, DeviceFault::Kind::stream},
                        Case{VIDIOC_QBUF, -ENODEV, DeviceFault::Kind::gone}}) {
    Bench bench;
    const auto camera = bench.started();
    bench.frame(0);
    bench.driver->errors[c.request] = {c.error};
    EXPECT_EQ(fault_of([&] { next(*camera); }), c.kind);
    bench.driver->frames.clear();
    bench.frame(1);
    camera->start();  // and back
    EXPECT_EQ(next(*camera).sequence, 1u);
  }
}

TEST(V4l2Faults, NoFrameHasAReason) {
  Bench bench;
  const auto camera = bench.started();
  EXPECT_EQ(fault_of([&] { next(*camera); }), DeviceFault::Kind::timeout);
  EXPECT_NO_THROW(camera->check_input());
  for (const std::uint32_t status : {V4L2_IN_ST_NO_SIGNAL, V4L2_IN_ST_NO_POWER, V4L2_IN_ST_NO_SYNC}) {
    bench.driver->input_status = status;
    EXPECT_EQ(fault_of([&] { next(*camera); }), DeviceFault::Kind::no_signal);
    EXPECT_EQ(fault_of([&] { camera->check_input(); }), DeviceFault::Kind::no_signal);
  }
  bench.driver->gone = true;
  EXPECT_EQ(fault_of([&] { next(*camera); }), DeviceFault::Kind::gone);
  EXPECT_EQ(fault_of([&] { camera->check_input(); }), DeviceFault::Kind::gone);
  EXPECT_EQ(fault_of([&] { camera->start(); }), DeviceFault::Kind::gone);
  EXPECT_EQ(fault_of([&] { next(*camera); }), DeviceFault::Kind::stream);  // it was not started again
}

// An error event without a reason must not be waited for without end.
TEST(V4l2Faults, AnErrorEventAloneEndsInATimeout) {
  Bench bench;
  const auto camera = bench.started();
  bench.driver->error_event = true;
  EXPECT_EQ(fault_of([&] { next(*camera); }), DeviceFault::Kind::timeout);
}

// Faults in any order leave neither a mapping nor an open device behind, and the camera usable.
TEST(V4l2Faults, AnyOrderOfThemLeavesNothingBehind) {
  std::mt19937 random(21);
  const unsigned long requests[] = {VIDIOC_REQBUFS, VIDIOC_QUERYBUF, VIDIOC_QBUF,
                                    VIDIOC_DQBUF,   VIDIOC_STREAMON, VIDIOC_STREAMOFF};
  Bench bench;
  {
    const auto camera = bench.camera();
    for (int i = 0; i < 300; ++i) {
      if (random() % 3 == 0)
        bench.driver->errors[requests[random() % std::size(requests)]].push_back(random() % 2 == 0 ? -EIO
                                                                                                   : -EINVAL);
      if (random() % 2 == 0) bench.frame(static_cast<std::uint32_t>(i), random() % 4 == 0 ? 7 : 32);
      try {
        if (random() % 8 == 0) camera->start();
        if (random() % 20 == 0) camera->stop();
        if (random() % 10 == 0) camera->drain();
        next(*camera);
      } catch (const UserError&) {
      }
    }
    bench.driver->errors.clear();
    bench.driver->frames.clear();
    camera->start();
    bench.frame(1000);
    EXPECT_EQ(next(*camera).sequence, 1000u);
  }
  EXPECT_EQ(bench.driver->mapped, 0);
  EXPECT_EQ(bench.driver->opened, 0);
  EXPECT_FALSE(bench.driver->streaming);
}

// --- what is agreed on

TEST(V4l2Format, TheDeepestGreyIsChosen) {
  Bench bench;
  bench.driver->formats = {V4L2_PIX_FMT_RGB24, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV,
                           V4L2_PIX_FMT_GREY,  V4L2_PIX_FMT_Y12,   V4L2_PIX_FMT_Y10};
  EXPECT_EQ(bench.camera()->info().provenance.at("format"), "Y12");
  EXPECT_EQ(bench.camera()->info().bit_depth, 12);
  bench.driver->formats.resize(3);
  EXPECT_EQ(bench.camera()->info().provenance.at("format"), "YUYV");
  bench.driver->formats.resize(1);
  EXPECT_THAT(bench.refusal(),
              HasSubstr("offers none of Y16, Y16-BE, Y12, Y10, GREY, YUYV, MJPG; it offers RGB3"));
}

TEST(V4l2Format, WhatTheDeviceChangesIsRefused) {
  const auto said = [](const auto& change) {
    Bench bench;
    bench.driver->sizes = {{8, 4}, {16, 8}};
    bench.driver->rates_hz = {30.0, 15.0};
    change(bench);
    return bench.refusal();
  };
  EXPECT_EQ(said([](Bench& b) { b.options.format.width = 16, b.options.format.height = 8; }), "none");
  EXPECT_EQ(said([](Bench& b) { b.options.format.width = 17, b.options.format.height = 9; }),
            "/dev/video0: gives 8x4 when asked for 17x9 in GREY; it offers 8x4, 16x8");
  EXPECT_EQ(said([](Bench& b) { b.driver->field = V4L2_FIELD_INTERLACED; }),
            "/dev/video0: gives interlaced fields; whole frames (progressive) are needed");
  EXPECT_EQ(said([](Bench& b) { b.options.format.rate_hz = 15.0; }), "none");
  EXPECT_EQ(said([](Bench& b) { b.options.format.rate_hz = 60.0; }),
            "/dev/video0: gives 30.000 Hz when asked for 60 Hz in GREY of 8x4");
  EXPECT_EQ(said([](Bench& b) { b.driver->rates_hz = {}, b.options.format.rate_hz = 60.0; }),
            "/dev/video0: has no rate to set; leave the rate out");
  EXPECT_THAT(said([](Bench& b) { b.options.format.shift = 1; }),
              HasSubstr("a shift of 1 leaves less than 8"));
  EXPECT_EQ(said([](Bench& b) { b.options.format.format = PixelFormat::y12; }),
            "/dev/video0: does not offer Y12; it offers GREY");
}

TEST(V4l2Format, OtherDevicesAreRefused) {
  Bench bench;
  bench.driver->caps = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  EXPECT_THAT(bench.refusal(), HasSubstr("/dev/video0: Fake camera has no video capture"));
  bench.driver->caps = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  EXPECT_THAT(bench.refusal(), HasSubstr("has multi-planar formats only (Fake camera)"));
  bench.driver->caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE;
  EXPECT_THAT(bench.refusal(), HasSubstr("does not stream into mapped memory"));
  bench.options.device = "/dev/video3";
  EXPECT_THAT(bench.refusal(), HasSubstr("/dev/video3: cannot be opened: No such file or directory; "));
  EXPECT_EQ(bench.driver->opened, 0);
}

TEST(V4l2Format, InfoHasWhatARecordNeeds) {
  Bench bench;
  bench.driver->rates_hz = {25.0};
  bench.options.format.rate_hz = 25.0;
  const CameraInfo info = bench.camera()->info();
  EXPECT_EQ(info.width, 8);
  EXPECT_EQ(info.height, 4);
  EXPECT_EQ(info.bit_depth, 8);
  EXPECT_DOUBLE_EQ(*info.period_ms, 40.0);
  for (const char* key :
       {"driver", "card", "bus", "driver_version", "kernel", "format", "size", "rate", "input"})
    EXPECT_TRUE(info.provenance.contains(key)) << key;
  EXPECT_EQ(info.provenance.at("driver_version"), "6.1.9");
}

TEST(V4l2List, NamesWhatIsOffered) {
  const auto driver = std::make_shared<FakeV4l2>();
  driver->formats = {V4L2_PIX_FMT_RGB24, V4L2_PIX_FMT_Y10};
  EXPECT_EQ(describe(list_v4l2_cameras(driver).at(0)),
            "/dev/video0: Fake camera (fake, usb-1)\n  Y10 8x4\n  not supported: RGB3\n");
  driver->caps = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  EXPECT_TRUE(list_v4l2_cameras(driver).empty());
  EXPECT_TRUE(list_v4l2_devices(driver).at(0).output);
  driver->caps = V4L2_CAP_META_CAPTURE;
  EXPECT_TRUE(list_v4l2_devices(driver).empty());
  EXPECT_EQ(driver->opened, 0);
}

}  // namespace
}  // namespace fringetwin::testing::v4l2_camera_test
