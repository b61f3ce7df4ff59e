// SPDX-License-Identifier: Apache-2.0
// A camera on the trigger line of a projector that runs by itself: what comes of each run is the test's. For
// *_test.cpp only.
#pragma once
#include <deque>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "capture/device/camera_device.hpp"

namespace fringetwin::testing {

/// A frame of a run, or what fails in its place.
struct PulsedFrame {
  capture::Frame frame = {};
  std::optional<capture::DeviceFault::Kind> fault = {};
};
using PulsedRun = std::vector<PulsedFrame>;

/// The frames of a run come as they are asked for; the next run begins once the program has looked back at
/// one (check_input()), or has started the camera anew.
class PulsedCamera final : public capture::CameraDevice {
 public:
  PulsedCamera(int width, int height, std::deque<PulsedRun> runs)
      : width_(width), height_(height), runs_(std::move(runs)) {}

  capture::CameraInfo info() const override {
    capture::CameraInfo info;
    info.device = "pulsed";
    info.width = width_;
    info.height = height_;
    info.pulse_line = "Line0";
    return info;
  }
  void start() override { next_run(); }
  void stop() noexcept override {}
  void drain() override {}
  void check_input() override { next_run(); }
  capture::Frame next_frame(std::chrono::milliseconds, Pixels) override {
    using capture::DeviceFault;
    if (runs_.empty() || at_ == runs_.front().size()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      throw DeviceFault(DeviceFault::Kind::timeout, "pulsed: no frame in time");
    }
    const PulsedFrame& next = runs_.front()[at_++];
    if (next.fault) throw DeviceFault(*next.fault, "pulsed: it fails");
    return next.frame;
  }
  double set_exposure_ms(double exposure_ms) override { return std::round(exposure_ms); }

 private:
  void next_run() {
    if (at_ > 0) runs_.pop_front();
    at_ = 0;
  }

  int width_, height_;
  std::deque<PulsedRun> runs_;
  std::size_t at_ = 0;
};

}  // namespace fringetwin::testing
