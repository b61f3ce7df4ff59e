// SPDX-License-Identifier: Apache-2.0
// Faults that the kernel's driver makes on request: each is seen as what it is, and the stream comes back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "capture/v4l2/v4l2_list.hpp"
#include "tests/vm/vivid.hpp"

namespace fringetwin::testing::faults_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;

constexpr auto timeout = 2000ms;

Frame next(V4l2Camera& camera) { return camera.next_frame(timeout, CameraDevice::Pixels::drop); }

template <class Call>
std::string device_fault(Call call) {
  try {
    call();
  } catch (const DeviceFault& fault) {
    switch (fault.kind()) {
      case DeviceFault::Kind::gone:
        return "gone";
      case DeviceFault::Kind::stream:
        return "stream";
      case DeviceFault::Kind::timeout:
        return "timeout";
      case DeviceFault::Kind::no_signal:
        return "no signal";
    }
  }
  return "none";
}

// Frames in a row, none lost, none faulty.
void expect_sound(V4l2Camera& camera) {
  Frame last = next(camera);
  for (int i = 0; i < 5; ++i) {
    const Frame frame = next(camera);
    EXPECT_EQ(frame.fault, FrameFault::none);
    EXPECT_EQ(frame.sequence, last.sequence + 1);
    EXPECT_NEAR(static_cast<double>(frame.timestamp_ns - last.timestamp_ns), vivid_period_ns,
                8e6);  // both ends fall on a tick of the kernel, 4 ms
    last = frame;
  }
}

TEST(VividFaults, EveryDroppedBufferIsAGapInTheSequence) {
  Vivid vivid(0);
  V4l2Camera camera(vivid.camera());
  camera.start();
  expect_sound(camera);
  vivid.set("percentage_of_dropped_buffers", 30);
  Frame last = next(camera);
  int lost = 0;
  for (int i = 0; i < 40; ++i) {
    const Frame frame = next(camera);
    const int steps = static_cast<int>(frame.sequence - last.sequence);
    lost += steps - 1;
    // the driver's clock agrees with its count
    EXPECT_EQ(std::lround(static_cast<double>(frame.timestamp_ns - last.timestamp_ns) / vivid_period_ns),
              steps);
    last = frame;
  }
  std::printf("30 %% of the buffers dropped: %d of %d lost\n", lost, lost + 40);
  EXPECT_GT(lost, 0);
  vivid.set("percentage_of_dropped_buffers", 0);
  next(camera);
  expect_sound(camera);
}

TEST(VividFaults, ErrorFlagMarksOneFrame) {
  Vivid vivid(0);
  V4l2Camera camera(vivid.camera());
  camera.start();
  next(camera);
  vivid.push("inject_v4l2_buf_flag_error");
  int marked = 0;
  for (int i = 0; i < 8; ++i) {
    const Frame frame = camera.next_frame(timeout, CameraDevice::Pixels::keep);
    EXPECT_EQ(frame.dn.empty(), frame.fault != FrameFault::none);
    EXPECT_TRUE(frame.fault == FrameFault::none || frame.fault == FrameFault::error_flag);
    marked += frame.fault == FrameFault::error_flag;
  }
  EXPECT_EQ(marked, 1);
}

TEST(VividFaults, StartIsTriedAgain) {
  Vivid vivid(0);
  for (const char* button : {"inject_vidioc_reqbufs_error", "inject_vidioc_streamon_error"}) {
    V4l2Camera camera(vivid.camera());
    vivid.push(button);
    camera.start();
    EXPECT_EQ(camera.refused_starts(), 1) << button;
    EXPECT_EQ(camera.info().provenance.at("refused_starts"), "1");
    expect_sound(camera);
  }
}

TEST(VividFaults, StreamBreaksAndComesBack) {
  Vivid vivid(0);
  V4l2Camera camera(vivid.camera());
  for (const char* button : {"inject_vidioc_qbuf_error", "inject_fatal_streaming_error"}) {
    camera.start();
    next(camera);
    vivid.push(button);
    const std::string seen = device_fault([&] {
      for (int i = 0; i < 8; ++i) next(camera);
    });
    EXPECT_EQ(seen, "stream") << button;
    camera.start();
    expect_sound(camera);
  }
}

TEST(VividFaults, NoSignalIsSeenThoughFramesCome) {
  Vivid vivid(0);
  V4l2Camera camera(vivid.camera());
  camera.start();
  next(camera);
  EXPECT_NO_THROW(camera.check_input());
  vivid.set("dv_timings_signal_mode", 1);
  EXPECT_EQ(device_fault([&] { camera.check_input(); }), "no signal");
  EXPECT_EQ(next(camera).fault, FrameFault::none);
  EXPECT_THROW(V4l2Camera{vivid.camera()}, UserError);
  vivid.set("dv_timings_signal_mode", 2);  // no lock
  EXPECT_EQ(device_fault([&] { camera.check_input(); }), "no signal");
  vivid.set("dv_timings_signal_mode", 0);
  EXPECT_NO_THROW(camera.check_input());
  expect_sound(camera);
}

TEST(VividFaults, TimeoutWhenNoFrameComes) {
  const Vivid vivid(0);
  V4l2Camera camera(vivid.camera());
  camera.start();
  camera.drain();
  EXPECT_EQ(device_fault([&] {
              for (int i = 0; i < 3; ++i) camera.next_frame(2ms, CameraDevice::Pixels::drop);
            }),
            "timeout");
  expect_sound(camera);
}

TEST(VividFaults, DrainLeavesNothingWaiting) {
  const Vivid vivid(0);
  V4l2Camera camera(vivid.camera());
  camera.start();
  next(camera);
  const TimeNs late = camera.now_ns() + static_cast<TimeNs>(4 * vivid_period_ns);
  while (camera.now_ns() < late) {
  }
  camera.drain();
  const TimeNs drained = camera.now_ns();
  EXPECT_GT(next(camera).timestamp_ns, drained - static_cast<TimeNs>(vivid_period_ns / 2));
}

TEST(VividFaults, ListNamesCamerasAndOutputs) {
  const std::vector<V4l2Listed> cameras = list_v4l2_cameras();
  ASSERT_GE(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].path, "/dev/video0");
  EXPECT_EQ(cameras[0].card, "vivid");
  EXPECT_THAT(describe(cameras[0]), ::testing::HasSubstr("Y16-BE"));
  bool output = false;
  for (const V4l2Listed& listed : list_v4l2_devices())
    output |= listed.path == "/dev/video1" && listed.output;
  EXPECT_TRUE(output);
  std::printf("%s", describe(cameras[0]).c_str());
}

// The device stays dead, so this instance is no other test's.
TEST(VividFaults, DisconnectIsGone) {
  Vivid vivid(2);
  V4l2Camera camera(vivid.camera());
  camera.start();
  next(camera);
  vivid.push("disconnect");
  EXPECT_EQ(device_fault([&] {
              for (int i = 0; i < 8; ++i) next(camera);
            }),
            "gone");
  EXPECT_EQ(device_fault([&] { camera.check_input(); }), "gone");
  EXPECT_EQ(device_fault([&] { camera.start(); }), "gone");
  EXPECT_THROW(V4l2Camera{vivid.camera()}, UserError);
}

}  // namespace
}  // namespace fringetwin::testing::faults_test
