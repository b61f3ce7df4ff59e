// SPDX-License-Identifier: Apache-2.0
// Cameras that see the projector's picture pixel for pixel, on a clock of their own, with faults at will. For
// *_test.cpp only.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"
#include "capture/device/pattern_display.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

enum class LoopFault { lost, repeated, error_flag, timeout, stream, no_signal, gone };

/// Frames come every 10 ms; a picture is seen whole from the first frame that begins `latency_ms` after it.
struct LoopWorld {
  capture::TimeNs now_ns = 0;
  capture::ImageU16 before, shown;  ///< what the light was before the last change, and is
  capture::TimeNs changed_ns = 0;
  std::uint64_t n_shown = 0;
  double latency_ms = 15.0;
  std::map<int, LoopFault> faults;  ///< by the number of the next_frame() call, all cameras counted together
  int calls = 0;
  int signal_missing = 0;  ///< check_input() calls that still see none
  bool gone = false;
  std::optional<double> exposure_step_ms;  ///< the cameras have an exposure control with that step
  int exposure_late_frames = 0;  ///< frames still taken with the exposure before; here they are black
};

class LoopCamera : public capture::CameraDevice {
 public:
  LoopCamera(std::shared_ptr<LoopWorld> world, int width, int height, double offset_ms)
      : world_(std::move(world)),
        width_(width),
        height_(height),
        next_end_ns_(capture::to_ns(offset_ms + kPeriodMs)) {}

  capture::CameraInfo info() const override {
    capture::CameraInfo info;
    info.device = "loop";
    info.width = width_;
    info.height = height_;
    info.bit_depth = 8;
    info.period_ms = kPeriodMs;
    info.timestamp_at_exposure_start = true;
    return info;
  }
  void start() override {
    if (world_->gone) throw capture::DeviceFault(capture::DeviceFault::Kind::gone, "loop: unplugged");
    running_ = true;
  }
  void stop() noexcept override { running_ = false; }
  void drain() override {
    while (next_end_ns_ <= world_->now_ns) advance();
  }
  void check_input() override {
    if (world_->signal_missing > 0) {
      --world_->signal_missing;
      throw capture::DeviceFault(capture::DeviceFault::Kind::no_signal, "loop: no signal");
    }
  }

  capture::Frame next_frame(std::chrono::milliseconds, Pixels pixels) override {
    if (!running_) throw capture::DeviceFault(capture::DeviceFault::Kind::stream, "loop: not started");
    const auto fault = world_->faults.find(world_->calls++);
    if (fault != world_->faults.end()) suffer(fault->second);
    capture::Frame frame;
    const bool repeat =
        fault != world_->faults.end() && fault->second == LoopFault::repeated && sequence_ > 0;
    if (repeat) {
      frame.sequence = sequence_ - 1;
      frame.timestamp_ns = last_ns_;
    } else {
      frame.sequence = sequence_;
      frame.timestamp_ns = last_ns_ = next_end_ns_ - capture::to_ns(kPeriodMs);
    }
    if (fault != world_->faults.end() && fault->second == LoopFault::error_flag) {
      frame.fault = capture::FrameFault::error_flag;
      frame.flags = 0x40;
    } else if (pixels == Pixels::keep) {
      frame.dn = frame.timestamp_ns >= world_->changed_ns ? world_->shown : world_->before;
      if (frame.timestamp_ns < exposed_from_ns_) frame.dn = capture::ImageU16(width_, height_);
    }
    if (!repeat) {
      world_->now_ns = std::max(world_->now_ns, next_end_ns_);
      advance();
    }
    return frame;
  }
  capture::TimeNs now_ns() const override { return world_->now_ns; }
  double set_exposure_ms(double exposure_ms) override {
    if (!world_->exposure_step_ms) return capture::CameraDevice::set_exposure_ms(exposure_ms);
    capture::TimeNs running_ns = next_end_ns_;  // the end of the frame that is being exposed
    while (running_ns <= world_->now_ns) running_ns += capture::to_ns(kPeriodMs);
    exposed_from_ns_ = running_ns + capture::to_ns(kPeriodMs * (world_->exposure_late_frames - 1));
    return std::round(exposure_ms / *world_->exposure_step_ms) * *world_->exposure_step_ms;
  }

  static constexpr double kPeriodMs = 10.0;

 private:
  void advance() {
    next_end_ns_ += capture::to_ns(kPeriodMs);
    ++sequence_;
  }
  void suffer(LoopFault fault) {
    switch (fault) {
      case LoopFault::lost:
        advance();
        break;
      case LoopFault::timeout:
        throw capture::DeviceFault(capture::DeviceFault::Kind::timeout, "loop: no frame for 2000 ms");
      case LoopFault::stream:
        running_ = false;
        throw capture::DeviceFault(capture::DeviceFault::Kind::stream, "loop: EIO");
      case LoopFault::no_signal:
        world_->signal_missing = 1;
        break;
      case LoopFault::gone:
        world_->gone = true;
        throw capture::DeviceFault(capture::DeviceFault::Kind::gone, "loop: unplugged");
      case LoopFault::repeated:
      case LoopFault::error_flag:
        break;
    }
  }

  std::shared_ptr<LoopWorld> world_;
  int width_, height_;
  capture::TimeNs next_end_ns_, last_ns_ = 0;
  capture::TimeNs exposed_from_ns_ = 0;  ///< frames that begin earlier have the exposure before
  std::uint32_t sequence_ = 0;
  bool running_ = false;
};

class LoopDisplay : public capture::PatternDisplay {
 public:
  LoopDisplay(std::shared_ptr<LoopWorld> world, int width, int height)
      : world_(std::move(world)), width_(width), height_(height) {}
  capture::DisplayInfo info() const override {
    capture::DisplayInfo info;
    info.device = "loop";
    info.width = width_;
    info.height = height_;
    info.timed = true;
    return info;
  }
  capture::Shown show(const capture::Pattern&, const ImageF& levels) override {
    world_->before = world_->shown.empty() ? capture::ImageU16(width_, height_) : world_->shown;
    world_->shown = capture::quantise_levels(levels, 8);
    world_->changed_ns = world_->now_ns + capture::to_ns(world_->latency_ms);
    return {world_->now_ns, ++world_->n_shown, true};
  }

 private:
  std::shared_ptr<LoopWorld> world_;
  int width_, height_;
};

/// A twin without objects whose cameras have the projector's size.
inline Twin loop_twin(std::size_t n_cameras, int bit_depth = 8) {
  Twin twin;
  twin.name = "loop";
  const Lens lens("LENSMODEL_PINHOLE", {100.0, 100.0, 31.5, 23.5}, {64, 48}, "test");
  for (std::size_t c = 0; c < n_cameras; ++c) {
    Camera camera{c == 0 ? "left" : "right", lens, Pose(), Sensor(), std::nullopt};
    camera.sensor.bit_depth = bit_depth;
    twin.cameras.push_back(camera);
  }
  twin.projector.emplace(Projector{.lens = lens, .T_proj_world = Pose(), .response = {}});
  DirectionFringes direction;
  direction.pitches_px = {13.0, 15.0};
  direction.phase_origin_px = {0.0, 0.0};
  twin.fringes.directions = {direction};
  return twin;
}

struct LoopRig {
  std::shared_ptr<LoopWorld> world = std::make_shared<LoopWorld>();
  capture::Rig cameras;
  std::unique_ptr<LoopDisplay> display;

  explicit LoopRig(const Twin& twin) {
    const int width = twin.projector->lens.width(), height = twin.projector->lens.height();
    display = std::make_unique<LoopDisplay>(world, width, height);
    for (std::size_t c = 0; c < twin.cameras.size(); ++c)
      cameras.push_back({twin.cameras[c].name, twin.cameras[c].sensor.bit_depth,
                         std::make_unique<LoopCamera>(world, width, height, 3.0 * static_cast<double>(c))});
  }
};

}  // namespace fringetwin::testing
