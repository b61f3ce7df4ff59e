// SPDX-License-Identifier: Apache-2.0
#include "capture/device/camera_device.hpp"

#include <fmt/format.h>

#include "twin/base/errors.hpp"

namespace fringetwin::capture {

// std::chrono::steady_clock is CLOCK_MONOTONIC on Linux, the clock of V4L2 and DRM.
TimeNs steady_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

const char* frame_fault_name(FrameFault fault) {
  switch (fault) {
    case FrameFault::none:
      return "none";
    case FrameFault::error_flag:
      return "error flag";
    case FrameFault::wrong_length:
      return "wrong length";
    case FrameFault::undecodable:
      return "undecodable";
    case FrameFault::missing_packets:
      return "missing packets";
  }
  return "?";
}

std::uint32_t FrameOrder::advance(const Frame& frame) {
  // Cameras count frames in 32 bits, which wrap: the difference tells the order.
  const std::int32_t ahead = sequence_ ? static_cast<std::int32_t>(frame.sequence - *sequence_) : 1;
  if (ahead <= 0 || (sequence_ && frame.timestamp_ns <= timestamp_ns_)) return 0;
  sequence_ = frame.sequence;
  timestamp_ns_ = frame.timestamp_ns;
  return static_cast<std::uint32_t>(ahead);
}

TimeNs exposure_begin_ns(const Frame& frame, const CameraInfo& info, std::optional<double> exposure_ms) {
  if (info.timestamp_at_exposure_start) return frame.timestamp_ns;
  // Where nobody knows the exposure it may last a whole period.
  return frame.timestamp_ns - to_ns(exposure_ms.value_or(info.period_ms.value_or(0.0)));
}

double CameraDevice::set_exposure_ms(double exposure_ms) {
  throw UserError(ExitCode::device, info().device,
                  fmt::format("has no exposure control, so {} ms cannot be set", exposure_ms),
                  "set the exposure at the camera and leave the option out");
}

TimeNs CameraDevice::now_ns() const { return steady_now_ns(); }

}  // namespace fringetwin::capture
