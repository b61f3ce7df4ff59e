// SPDX-License-Identifier: Apache-2.0
// The kernel's test driver vivid: instances whose capture shows what their output plays, with faults on
// request.
#pragma once
#include "capture/v4l2/v4l2_camera.hpp"
#include "capture/v4l2/v4l2_display.hpp"

namespace fringetwin::testing {

constexpr int vivid_width = 1280, vivid_height = 720;
constexpr double vivid_rate_hz = 24.0;
constexpr double vivid_period_ns = 1e9 / vivid_rate_hz;

/// One instance; its controls are reset when it is made.
class Vivid {
 public:
  explicit Vivid(int instance);

  std::string capture_path() const { return capture_path_; }
  std::string output_path() const { return output_path_; }
  capture::V4l2CameraOptions camera(capture::PixelFormat format = capture::PixelFormat::grey) const;
  capture::V4l2DisplayOptions display(capture::PixelFormat format = capture::PixelFormat::grey) const;

  void set(const std::string& control, std::int64_t value) { controls_.set(controls_.named(control), value); }
  void push(const std::string& button) { controls_.push(controls_.named(button)); }

 private:
  std::string capture_path_, output_path_;
  capture::V4l2Device device_, output_;
  capture::V4l2Controls controls_;
};

/// Fringes along x and y, four steps each.
Fringes vivid_fringes();

}  // namespace fringetwin::testing
