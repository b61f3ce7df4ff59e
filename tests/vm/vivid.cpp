// SPDX-License-Identifier: Apache-2.0
#include "tests/vm/vivid.hpp"

#include <fmt/format.h>

#include <cmath>

namespace fringetwin::testing {
namespace {

using namespace fringetwin::capture;

// The capture's timings stand for its source's, and only those of the output are looped through.
void set_timings(const V4l2Device& device) {
  v4l2_enum_dv_timings entry{};
  for (; device.call(VIDIOC_ENUM_DV_TIMINGS, entry) == 0; ++entry.index) {
    const v4l2_bt_timings& bt = entry.timings.bt;
    const double rate_hz = static_cast<double>(bt.pixelclock) /
                           (static_cast<double>(V4L2_DV_BT_FRAME_WIDTH(&bt)) * V4L2_DV_BT_FRAME_HEIGHT(&bt));
    if (bt.width == vivid_width && bt.height == vivid_height && std::abs(rate_hz - vivid_rate_hz) < 1e-3) {
      const int result = device.call(VIDIOC_S_DV_TIMINGS, entry.timings);
      if (result != 0) throw device.refusal("timings not taken: " + error_text(result));
      return;
    }
  }
  throw device.refusal("does not have the timings of the test");
}

}  // namespace

Vivid::Vivid(int instance)
    : capture_path_(fmt::format("/dev/video{}", 2 * instance)),
      output_path_(fmt::format("/dev/video{}", 2 * instance + 1)),
      device_(kernel_v4l2(), capture_path_, V4L2_CAP_VIDEO_CAPTURE),
      output_(kernel_v4l2(), output_path_, V4L2_CAP_VIDEO_OUTPUT),
      controls_(device_) {
  set("dv_timings_signal_mode", 0);  // as set
  set("percentage_of_dropped_buffers", 0);
  set("osd_text_mode", 2);  // none
  set("loop_video", 1);
  set_timings(device_);
  set_timings(output_);
}

V4l2CameraOptions Vivid::camera(PixelFormat format) const {
  V4l2CameraOptions options;
  options.device = capture_path_;
  options.format = {format, vivid_width, vivid_height, vivid_rate_hz, 0};
  return options;
}

V4l2DisplayOptions Vivid::display(PixelFormat format) const {
  V4l2DisplayOptions options;
  options.device = output_path_;
  options.format = {format, vivid_width, vivid_height, vivid_rate_hz, 0};
  return options;
}

Fringes vivid_fringes() {
  Fringes fringes;
  fringes.steps = 4;
  for (const Axis axis : {Axis::x, Axis::y}) {
    DirectionFringes direction;
    direction.axis = axis;
    direction.pitches_px = {axis == Axis::x ? 53.0 : 47.0};
    direction.phase_origin_px = {0.0};
    fringes.directions.push_back(direction);
  }
  return fringes;
}

}  // namespace fringetwin::testing
