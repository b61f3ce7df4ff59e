// SPDX-License-Identifier: Apache-2.0
// Agrees with a video device on format, size and rate, and says what was agreed.
#pragma once
#include "capture/device/pixel_format.hpp"
#include "capture/v4l2/v4l2_device.hpp"

namespace fringetwin::capture {

struct V4l2FormatWish {
  std::optional<PixelFormat> format;  ///< none: the first of pixel_formats() that is offered
  int width = 0, height = 0;          ///< 0: as the device has it
  std::optional<double> rate_hz;
  int shift = 0;
  std::string mosaic = {};  ///< of the twin's camera: only formats of it, "RGGB"; "": monochrome unless named
};

struct V4l2Agreed {
  FrameLayout layout;
  std::optional<double> period_ms;
  bool has_timings = false;  ///< an input like HDMI, whose source sets size and rate
  v4l2_dv_timings timings{};
  std::map<std::string, std::string> provenance;
};

/// Throws UserError(device) unless the device does exactly what is wished.
V4l2Agreed agree_on_capture(const V4l2Device& device, const V4l2FormatWish& wish);
V4l2Agreed agree_on_output(const V4l2Device& device, const V4l2FormatWish& wish);

/// "" when the input delivers a picture as agreed, else what is wrong; throws DeviceFault(gone).
std::string input_trouble(const V4l2Device& device, const V4l2Agreed& agreed);

/// Four-character codes of a queue, in the driver's order.
std::vector<std::uint32_t> offered_formats(const V4l2Device& device, v4l2_buf_type type);
/// "640x480", "16x16 to 1920x1080"; empty where the driver does not say.
std::vector<std::string> offered_sizes(const V4l2Device& device, std::uint32_t fourcc);

}  // namespace fringetwin::capture
