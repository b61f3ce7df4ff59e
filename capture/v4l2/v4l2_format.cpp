// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_format.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

namespace fringetwin::capture {
namespace {

// A third of the step from 30 to 29.97 Hz.
constexpr double kSameRate = 3e-4;

double rate_of(const v4l2_dv_timings& timings) {
  const v4l2_bt_timings& bt = timings.bt;
  const double pixels = static_cast<double>(V4L2_DV_BT_FRAME_WIDTH(&bt)) * V4L2_DV_BT_FRAME_HEIGHT(&bt);
  return pixels > 0 ? static_cast<double>(bt.pixelclock) / pixels : 0.0;
}

std::string timings_text(const v4l2_dv_timings& timings) {
  return fmt::format("{}x{}{} at {:.3f} Hz", timings.bt.width, timings.bt.height,
                     timings.bt.interlaced ? "i" : "", rate_of(timings));
}

bool differs(double rate_hz, double wished_hz) { return std::abs(rate_hz / wished_hz - 1.0) > kSameRate; }

bool as_wished(const v4l2_dv_timings& timings, const V4l2FormatWish& wish) {
  return (wish.width == 0 || static_cast<int>(timings.bt.width) == wish.width) &&
         (wish.height == 0 || static_cast<int>(timings.bt.height) == wish.height) &&
         (!wish.rate_hz || !differs(rate_of(timings), *wish.rate_hz)) && timings.bt.interlaced == 0;
}

std::string wish_text(const V4l2FormatWish& wish) {
  return (wish.width > 0 ? fmt::format("{}x{}", wish.width, wish.height) : "its size") +
         (wish.rate_hz ? fmt::format(" at {} Hz", *wish.rate_hz) : "");
}

// --- inputs and outputs like HDMI

v4l2_dv_timings detected_timings(const V4l2Device& device) {
  v4l2_dv_timings timings{};
  const int result = device.call(VIDIOC_QUERY_DV_TIMINGS, timings);
  if (result == -ENOLINK)
    throw device.refusal("has no signal at its input", "connect and switch on the source");
  if (result != 0) throw device.refusal("cannot tell its source's timings: " + error_text(result));
  return timings;
}

// The present ones where they serve: what is connected to an output knows them already.
v4l2_dv_timings found_timings(const V4l2Device& device, const V4l2FormatWish& wish) {
  v4l2_dv_timings present{};
  if (device.call(VIDIOC_G_DV_TIMINGS, present) == 0 && as_wished(present, wish)) return present;
  v4l2_enum_dv_timings entry{};
  for (; device.call(VIDIOC_ENUM_DV_TIMINGS, entry) == 0; ++entry.index)
    if (as_wished(entry.timings, wish)) return entry.timings;
  throw device.refusal("has no timings for " + wish_text(wish));
}

void set_timings(const V4l2Device& device, const V4l2FormatWish& wish, v4l2_dv_timings timings,
                 V4l2Agreed& agreed) {
  if (!as_wished(timings, wish))
    throw device.refusal(
        fmt::format("gets {} from its source, not {}", timings_text(timings), wish_text(wish)),
        timings.bt.interlaced ? "the source must send whole frames" : "set the source's mode");
  if (const int result = device.call(VIDIOC_S_DV_TIMINGS, timings); result != 0)
    throw device.refusal(fmt::format("does not take {}: {}", timings_text(timings), error_text(result)));
  agreed.has_timings = true;
  agreed.timings = timings;
  agreed.period_ms = 1000.0 / rate_of(timings);
  agreed.provenance["timings"] = timings_text(timings);
}

// --- format and size

PixelFormat chosen_format(const V4l2Device& device, v4l2_buf_type type, const V4l2FormatWish& wish) {
  const std::vector<std::uint32_t> offered = offered_formats(device, type);
  std::vector<std::string> names;
  for (const std::uint32_t fourcc : offered) names.push_back(fourcc_text(fourcc));
  for (const PixelFormatTraits& t : pixel_formats()) {
    if (wish.format ? *wish.format != t.format : wish.mosaic != t.mosaic) continue;
    if (type == V4L2_BUF_TYPE_VIDEO_OUTPUT && t.bytes_per_pixel == 0) continue;
    const bool has = std::ranges::any_of(
        offered, [&](std::uint32_t fourcc) { return pixel_format_of_fourcc(fourcc) == t.format; });
    if (has) return t.format;
  }
  throw device.refusal(wish.format ? fmt::format("does not offer {}", traits(*wish.format).name)
                                   : "offers none of " + pixel_format_names(wish.mosaic),
                       fmt::format("it offers {}", fmt::join(names, ", ")));
}

// MJPG goes by two names.
std::uint32_t fourcc_offered(const V4l2Device& device, v4l2_buf_type type, PixelFormat format) {
  for (const std::uint32_t fourcc : offered_formats(device, type))
    if (pixel_format_of_fourcc(fourcc) == format) return fourcc;
  return traits(format).fourcc;
}

// A crop left over from another program would scale the picture.
void uncrop(const V4l2Device& device, v4l2_buf_type type) {
  v4l2_selection selection{};
  selection.type = type;
  selection.target = V4L2_SEL_TGT_CROP_DEFAULT;
  if (device.call(VIDIOC_G_SELECTION, selection) != 0) return;
  selection.target = V4L2_SEL_TGT_CROP;
  device.call(VIDIOC_S_SELECTION, selection);
}

void note_crop(const V4l2Device& device, v4l2_buf_type type, V4l2Agreed& agreed) {
  v4l2_selection selection{};
  selection.type = type;
  selection.target = V4L2_SEL_TGT_CROP;
  if (device.call(VIDIOC_G_SELECTION, selection) == 0)
    agreed.provenance["crop"] = fmt::format("{}x{} from {},{}", selection.r.width, selection.r.height,
                                            selection.r.left, selection.r.top);
}

void refuse_other_format(const V4l2Device& device, const v4l2_pix_format& got, std::uint32_t fourcc,
                         int width, int height) {
  if (got.pixelformat != fourcc)
    throw device.refusal(
        fmt::format("gives {} when asked for {}", fourcc_text(got.pixelformat), fourcc_text(fourcc)));
  if (static_cast<int>(got.width) != width || static_cast<int>(got.height) != height) {
    const std::vector<std::string> sizes = offered_sizes(device, fourcc);
    throw device.refusal(fmt::format("gives {}x{} when asked for {}x{} in {}", got.width, got.height, width,
                                     height, fourcc_text(fourcc)),
                         sizes.empty() ? "" : fmt::format("it offers {}", fmt::join(sizes, ", ")));
  }
  if (got.field != V4L2_FIELD_NONE)
    throw device.refusal("gives interlaced fields", "whole frames (progressive) are needed");
}

FrameLayout layout_of(const v4l2_pix_format& got, PixelFormat format, const V4l2FormatWish& wish) {
  const PixelFormatTraits& t = traits(format);
  FrameLayout layout{format,    static_cast<int>(got.width), static_cast<int>(got.height), 0, got.sizeimage,
                     wish.shift};
  if (t.bytes_per_pixel > 0)
    layout.bytes_per_line =
        std::max<std::size_t>(got.bytesperline, got.width * static_cast<unsigned>(t.bytes_per_pixel));
  return layout;
}

void set_format(const V4l2Device& device, v4l2_buf_type type, const V4l2FormatWish& wish,
                V4l2Agreed& agreed) {
  const PixelFormat format = chosen_format(device, type, wish);
  if (!wish.mosaic.empty() && wish.mosaic != traits(format).mosaic)
    throw device.refusal(
        fmt::format("gives {}, the twin's sensor is a mosaic {}", traits(format).name, wish.mosaic),
        "leave --format out, or check mosaic in [camera.sensor]");
  if (wish.shift < 0 || wish.shift > traits(format).bit_depth - 8)
    throw device.refusal(fmt::format("a shift of {} leaves less than 8 of {}'s {} bits", wish.shift,
                                     traits(format).name, traits(format).bit_depth));
  v4l2_format wanted{};
  wanted.type = type;
  if (const int result = device.call(VIDIOC_G_FMT, wanted); result != 0)
    throw device.refusal("does not tell its format: " + error_text(result));
  v4l2_pix_format& pix = wanted.fmt.pix;
  if (agreed.has_timings) {
    pix.width = agreed.timings.bt.width;
    pix.height = agreed.timings.bt.height;
  } else if (wish.width > 0) {
    pix.width = static_cast<std::uint32_t>(wish.width);
    pix.height = static_cast<std::uint32_t>(wish.height);
  }
  pix.pixelformat = fourcc_offered(device, type, format);
  pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = 0;
  pix.sizeimage = 0;
  const v4l2_pix_format asked = pix;
  if (const int result = device.call(VIDIOC_S_FMT, wanted); result != 0)
    throw device.refusal(
        fmt::format("does not take {}: {}", fourcc_text(asked.pixelformat), error_text(result)),
        result == -EBUSY ? "another program has it" : "");
  refuse_other_format(device, pix, asked.pixelformat, static_cast<int>(asked.width),
                      static_cast<int>(asked.height));
  agreed.layout = layout_of(pix, format, wish);
  agreed.provenance["format"] = traits(format).name;
  agreed.provenance["size"] = fmt::format("{}x{}", pix.width, pix.height);
  agreed.provenance["bytes_per_line"] = std::to_string(agreed.layout.bytes_per_line);
  if (pix.quantization == V4L2_QUANTIZATION_LIM_RANGE)
    agreed.provenance["range"] = "limited: white is 235, what is above is not told from saturation";
  agreed.provenance["colorspace"] =
      fmt::format("{}, quantization {}, transfer {}", pix.colorspace, pix.quantization, pix.xfer_func);
}

// --- rate

void set_rate(const V4l2Device& device, v4l2_buf_type type, const V4l2FormatWish& wish, V4l2Agreed& agreed) {
  if (agreed.has_timings) return;
  v4l2_streamparm parameters{};
  parameters.type = type;
  const int result = device.call(VIDIOC_G_PARM, parameters);
  // The same layout serves captures and outputs.
  v4l2_captureparm& capture = parameters.parm.capture;
  const bool can = result == 0 && (capture.capability & V4L2_CAP_TIMEPERFRAME) != 0;
  if (wish.rate_hz && !can) throw device.refusal("has no rate to set", "leave the rate out");
  if (wish.rate_hz) {
    capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(*wish.rate_hz * 1000.0))};
    if (const int set = device.call(VIDIOC_S_PARM, parameters); set != 0)
      throw device.refusal(fmt::format("does not take {} Hz: {}", *wish.rate_hz, error_text(set)));
  }
  if (!can || capture.timeperframe.numerator == 0 || capture.timeperframe.denominator == 0) return;
  const double rate = static_cast<double>(capture.timeperframe.denominator) / capture.timeperframe.numerator;
  if (wish.rate_hz && differs(rate, *wish.rate_hz))
    throw device.refusal(fmt::format("gives {:.3f} Hz when asked for {} Hz in {} of {}", rate, *wish.rate_hz,
                                     agreed.provenance["format"], agreed.provenance["size"]));
  agreed.period_ms = 1000.0 / rate;
  agreed.provenance["rate"] = fmt::format("{:.3f} Hz", rate);
}

}  // namespace

std::vector<std::uint32_t> offered_formats(const V4l2Device& device, v4l2_buf_type type) {
  std::vector<std::uint32_t> formats;
  v4l2_fmtdesc entry{};
  entry.type = type;
  for (; device.call(VIDIOC_ENUM_FMT, entry) == 0; ++entry.index) formats.push_back(entry.pixelformat);
  return formats;
}

std::vector<std::string> offered_sizes(const V4l2Device& device, std::uint32_t fourcc) {
  std::vector<std::string> sizes;
  v4l2_frmsizeenum entry{};
  entry.pixel_format = fourcc;
  for (; device.call(VIDIOC_ENUM_FRAMESIZES, entry) == 0; ++entry.index) {
    if (entry.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
      const v4l2_frmsize_stepwise& s = entry.stepwise;
      sizes.push_back(fmt::format("{}x{} to {}x{}", s.min_width, s.min_height, s.max_width, s.max_height));
      break;
    }
    sizes.push_back(fmt::format("{}x{}", entry.discrete.width, entry.discrete.height));
  }
  return sizes;
}

V4l2Agreed agree_on_capture(const V4l2Device& device, const V4l2FormatWish& wish) {
  V4l2Agreed agreed;
  v4l2_input input{};
  if (device.call(VIDIOC_G_INPUT, input.index) == 0 && device.call(VIDIOC_ENUMINPUT, input) == 0) {
    agreed.provenance["input"] = text_of(input.name);
    if ((input.capabilities & V4L2_IN_CAP_DV_TIMINGS) != 0)
      set_timings(device, wish, detected_timings(device), agreed);
  }
  uncrop(device, V4L2_BUF_TYPE_VIDEO_CAPTURE);
  set_format(device, V4L2_BUF_TYPE_VIDEO_CAPTURE, wish, agreed);
  note_crop(device, V4L2_BUF_TYPE_VIDEO_CAPTURE, agreed);
  set_rate(device, V4L2_BUF_TYPE_VIDEO_CAPTURE, wish, agreed);
  return agreed;
}

V4l2Agreed agree_on_output(const V4l2Device& device, const V4l2FormatWish& wish) {
  V4l2Agreed agreed;
  v4l2_output output{};
  if (device.call(VIDIOC_G_OUTPUT, output.index) == 0 && device.call(VIDIOC_ENUMOUTPUT, output) == 0) {
    agreed.provenance["output"] = text_of(output.name);
    if ((output.capabilities & V4L2_OUT_CAP_DV_TIMINGS) != 0)
      set_timings(device, wish, found_timings(device, wish), agreed);
  }
  set_format(device, V4L2_BUF_TYPE_VIDEO_OUTPUT, wish, agreed);
  set_rate(device, V4L2_BUF_TYPE_VIDEO_OUTPUT, wish, agreed);
  return agreed;
}

std::string input_trouble(const V4l2Device& device, const V4l2Agreed& agreed) {
  const auto gone = [&](int result) {
    if (is_gone(result)) throw_device_fault(device, result, "");
    return result;
  };
  v4l2_input input{};
  if (gone(device.call(VIDIOC_G_INPUT, input.index)) != 0 || gone(device.call(VIDIOC_ENUMINPUT, input)) != 0)
    return "";
  constexpr std::uint32_t kUnlocked = V4L2_IN_ST_NO_H_LOCK | V4L2_IN_ST_NO_V_LOCK | V4L2_IN_ST_NO_STD_LOCK |
                                      V4L2_IN_ST_NO_SYNC | V4L2_IN_ST_NO_EQU | V4L2_IN_ST_NO_CARRIER;
  const std::string name = "input " + text_of(input.name);
  if ((input.status & V4L2_IN_ST_NO_POWER) != 0) return name + " has no power";
  if ((input.status & V4L2_IN_ST_NO_SIGNAL) != 0) return name + " has no signal";
  if ((input.status & kUnlocked) != 0) return name + " has no lock on its signal";
  if (!agreed.has_timings) return "";
  v4l2_dv_timings now{};
  const int result = gone(device.call(VIDIOC_QUERY_DV_TIMINGS, now));
  if (result == -ENOLINK) return name + " has no signal";
  if (result == -ENOLCK || result == -ERANGE) return name + " has no lock on its signal";
  if (result != 0) return "";  // some drivers cannot tell while they stream
  if (now.bt.width != agreed.timings.bt.width || now.bt.height != agreed.timings.bt.height ||
      differs(rate_of(now), rate_of(agreed.timings)))
    return fmt::format("{} changed to {} from {}", name, timings_text(now), timings_text(agreed.timings));
  return "";
}

}  // namespace fringetwin::capture
