// SPDX-License-Identifier: Apache-2.0
#include "capture/genicam/genicam_region.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "twin/base/paths.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::capture {
namespace {

/// Features that other options answer for, and which.
constexpr std::array<std::pair<const char*, const char*>, 8> kOthers{{
    {"Width", "the twin's imagersize sets it"},
    {"Height", "the twin's imagersize sets it"},
    {"PixelFormat", "use --format"},
    {"ExposureTime", "use --exposure-ms"},
    {"ExposureTimeAbs", "use --exposure-ms"},
    {"TriggerMode", "use --trigger"},
    {"TriggerSource", "use --trigger"},
    {"TriggerSelector", "use --trigger"},
}};

bool is_offset(const std::string& name) {
  const std::string lower = lower_case(name);
  return lower == "offsetx" || lower == "offsety";
}

std::string offset_of(const GenicamCameraOptions& options, const std::string& name) {
  for (const auto& [key, value] : options.controls)
    if (lower_case(key) == lower_case(name)) return value;
  return "0";
}

/// The format of the twin's own depth in as few bytes as may be, else the deepest; of the twin's mosaic, or
/// monochrome, for another mosaic is no image of the twin's camera.
const PfncFormat* preferred_format(const GenicamFeature& offered, const GenicamCameraOptions& options) {
  const PfncFormat* chosen = nullptr;
  for (const PfncFormat& format : pfnc_formats()) {
    if (!format.is_of(options.mosaic) || !offered.has_choice(format.name)) continue;
    if (format.bit_depth == options.stored_bits) return &format;
    if (chosen == nullptr) chosen = &format;
  }
  return chosen;
}

const PfncFormat& chosen_format(const GenicamSettings& settings, const GenicamCameraOptions& options) {
  const GenicamFeature offered = settings.feature("PixelFormat");
  const PfncFormat* format =
      options.format.empty() ? preferred_format(offered, options) : pfnc_format_of_name(options.format);
  const std::string has = fmt::format("it has {}", fmt::join(offered.choices, ", "));
  if (!options.format.empty() && format == nullptr)
    throw settings.refusal(fmt::format("'{}' is none of the formats that are understood", options.format),
                           has);
  if (format == nullptr && !options.mosaic.empty())
    throw settings.refusal(
        fmt::format("offers no format of the mosaic {} that the twin's sensor has", options.mosaic),
        has + "; check mosaic in [camera.sensor]");
  if (format == nullptr)
    throw settings.refusal(
        "offers no monochrome format",
        has +
            "; a twin of a colour sensor says mosaic and channel in [camera.sensor], a Bayer "
            "format named with --format is recorded as its raw mosaic");
  if (!offered.has_choice(format->name))
    throw settings.refusal(fmt::format("does not offer {}", format->name), has);
  if (!options.mosaic.empty() && !format->is_of(options.mosaic))
    throw settings.refusal(
        fmt::format("gives {}, the twin's sensor is a mosaic {}", format->name, options.mosaic),
        "leave --format out, or check mosaic in [camera.sensor]");
  return *format;
}

int full_size(const GenicamSettings& settings, const char* of_sensor, const char* feature) {
  const GenicamFeature whole = settings.feature(of_sensor);
  if (const auto size = parse_number<int>(whole.value); whole.readable && size && *size > 0) return *size;
  return static_cast<int>(settings.feature(feature).max);
}

void check_region(const GenicamSettings& settings, const GenicamCameraOptions& options) {
  const int width = full_size(settings, "WidthMax", "Width"),
            height = full_size(settings, "HeightMax", "Height");
  const bool named =
      std::ranges::any_of(options.controls, [](const auto& control) { return is_offset(control.first); });
  if (named || (width == options.width && height == options.height)) return;
  throw settings.refusal(
      fmt::format("has {} x {} px, the twin's camera {} x {}", width, height, options.width, options.height),
      "a twin of a region says where it begins: --control OffsetX=… --control OffsetY=… (its principal point "
      "counts from there); a binned one by how much: --control BinningHorizontal=2 --control "
      "BinningVertical=2; else check imagersize");
}

}  // namespace

void check_controls(const GenicamCameraOptions& options) {
  for (const auto& [name, value] : options.controls)
    for (const auto& [feature, instead] : kOthers)
      if (lower_case(name) == lower_case(feature))
        throw UserError(ExitCode::usage, fmt::format("--control {}={}", name, value),
                        "this feature is not set by hand", instead);
}

void reset_geometry(const GenicamSettings& settings, const std::set<std::string>& named) {
  constexpr std::array<std::pair<const char*, const char*>, 6> kPlain{{{"BinningHorizontal", "1"},
                                                                       {"BinningVertical", "1"},
                                                                       {"DecimationHorizontal", "1"},
                                                                       {"DecimationVertical", "1"},
                                                                       {"ReverseX", "false"},
                                                                       {"ReverseY", "false"}}};
  for (const auto& [feature, value] : kPlain)
    if (!named.contains(feature)) settings.set_where_there(feature, value);
}

PfncLayout set_region_and_format(const GenicamSettings& settings, const GenicamCameraOptions& options) {
  const PfncFormat& format = chosen_format(settings, options);
  if (options.shift < 0 || options.shift > format.bit_depth - 8)
    throw settings.refusal(fmt::format("a shift of {} leaves less than 8 of {}'s {} bits", options.shift,
                                       format.name, format.bit_depth));
  settings.set("PixelFormat", format.name);
  settings.set_where_there("OffsetX", "0");  // which limit the size
  settings.set_where_there("OffsetY", "0");
  check_region(settings, options);
  settings.set("Width", std::to_string(options.width));
  settings.set("Height", std::to_string(options.height));
  for (const char* offset : {"OffsetX", "OffsetY"})
    if (const std::string value = offset_of(options, offset); value != "0") settings.set(offset, value);
  PfncLayout layout{
      .format = &format, .width = options.width, .height = options.height, .shift = options.shift};
  const auto payload = static_cast<std::size_t>(settings.number("PayloadSize"));
  if (payload < layout.used_bytes())
    throw settings.refusal(fmt::format("sends {} bytes for a frame of {} in {} x {} px, which needs {}",
                                       payload, format.name, options.width, options.height,
                                       layout.used_bytes()));
  // Lines that begin with a byte of their own make a frame of just that size.
  PfncLayout whole_lines = layout;
  whole_lines.lines_are_whole = true;
  if (payload != layout.used_bytes() && payload == whole_lines.used_bytes()) layout = whole_lines;
  layout.frame_padding = payload - layout.used_bytes();
  return layout;
}

}  // namespace fringetwin::capture
