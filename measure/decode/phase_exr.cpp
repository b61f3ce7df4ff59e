// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/phase_exr.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "twin/image/image_io.hpp"

namespace fringetwin::measure {
namespace {

template <class At>
PhaseChannel channel_of(std::string name, const ImageF* image, const At& at) {
  const auto copy = [at](std::size_t first, std::span<float> out) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = at(first + i);
  };
  return {.name = std::move(name), .image = image, .at = at, .copy = copy};
}

/// Returns a channel that is NaN where another image is.
template <class T>
PhaseChannel masked(std::string name, const ImageF& image, const Image<T>& validity) {
  return channel_of(std::move(name), nullptr,
                    [values = image.data.data(), valid = validity.data.data()](std::size_t i) {
                      return std::isfinite(valid[i]) ? values[i] : std::numeric_limits<float>::quiet_NaN();
                    });
}

PhaseChannel masked_by_validity(std::string name, const ImageF& image, const DirectionDecode& d) {
  return d.wrapped_rad.empty() ? masked(std::move(name), image, d.coordinate_px)
                               : masked(std::move(name), image, d.wrapped_rad[d.finest]);
}

PhaseChannel as_it_is(std::string name, const ImageF& image) {
  return channel_of(std::move(name), &image,
                    [values = image.data.data()](std::size_t i) { return values[i]; });
}

PhaseChannel to_float(std::string name, const ImageD& image) {
  return channel_of(std::move(name), nullptr,
                    [values = image.data.data()](std::size_t i) { return static_cast<float>(values[i]); });
}

ImageF image_of(const PhaseChannel& channel, const CameraDecode& decode) {
  if (channel.image) return *channel.image;
  ImageF out(decode.width(), decode.height());
  channel.copy(0, out.data);
  return out;
}

}  // namespace

std::string wrapped_channel_name(Axis axis, double pitch_px) {
  char text[400];
  // fixed: an exponent's '+' or '-' would not be a plain channel name
  const auto end = std::to_chars(text, text + sizeof text, pitch_px, std::chars_format::fixed).ptr;
  std::string pitch(text, end);
  std::ranges::replace(pitch, '.', 'p');
  return std::string("wrapped_") + axis_name(axis) + "_" + pitch;
}

std::vector<PhaseChannel> phase_channel_values(const CameraDecode& decode) {
  std::vector<PhaseChannel> channels;
  for (std::size_t i = 0; i < decode.directions.size(); ++i) {
    const DirectionDecode& d = decode.directions[i];
    for (std::size_t p = 0; p < d.wrapped_rad.size(); ++p)
      channels.push_back(as_it_is(wrapped_channel_name(d.axis, d.pitches_px[p]), d.wrapped_rad[p]));
    if (d.unwrapped && !d.coordinate_px.empty())
      channels.push_back(to_float(d.axis == Axis::x ? "column_px" : "row_px", d.coordinate_px));
    const std::string suffix = i == 0 ? "" : std::string("_") + axis_name(d.axis);
    if (d.amplitude_dn.empty()) continue;
    const std::size_t finest = d.wrapped_rad.empty() ? 0 : static_cast<std::size_t>(d.finest);
    channels.push_back(masked_by_validity("amplitude_dn" + suffix, d.amplitude_dn[finest], d));
    channels.push_back(masked_by_validity("mean_dn" + suffix, d.mean_dn, d));
    channels.push_back(masked_by_validity("sigma_rad" + suffix, d.sigma_rad, d));
  }
  return channels;
}

std::vector<std::pair<std::string, ImageF>> phase_channels(const CameraDecode& decode) {
  std::vector<std::pair<std::string, ImageF>> channels;
  for (const PhaseChannel& channel : phase_channel_values(decode))
    channels.emplace_back(channel.name, image_of(channel, decode));
  return channels;
}

void write_phase_exr(const std::filesystem::path& dir, const CameraDecode& decode) {
  std::deque<ImageF> made;  // whose elements stay where they are
  std::vector<NamedChannel> named;
  for (const PhaseChannel& channel : phase_channel_values(decode))
    named.emplace_back(channel.name,
                       channel.image ? channel.image : &made.emplace_back(image_of(channel, decode)));
  write_exr(dir / ("phase_" + decode.camera + ".exr"), named);
}

}  // namespace fringetwin::measure
