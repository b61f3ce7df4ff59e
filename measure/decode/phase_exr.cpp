// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/phase_exr.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "twin/image/image_io.hpp"

namespace fringetwin::measure {
namespace {

ImageF to_float(const ImageD& image) {
  ImageF out(image.width, image.height);
  std::transform(image.data.begin(), image.data.end(), out.data.begin(),
                 [](double v) { return static_cast<float>(v); });
  return out;
}

template <class T>
ImageF masked(const ImageF& image, const Image<T>& validity) {
  ImageF out = image;
  for (std::size_t i = 0; i < out.size(); ++i)
    if (!std::isfinite(validity.data[i])) out.data[i] = std::numeric_limits<float>::quiet_NaN();
  return out;
}

ImageF masked_by_validity(const ImageF& image, const DirectionDecode& d) {
  if (d.wrapped_rad.empty()) return masked(image, d.coordinate_px);
  return masked(image, d.wrapped_rad[d.finest]);
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

std::vector<std::pair<std::string, ImageF>> phase_channels(const CameraDecode& decode) {
  std::vector<std::pair<std::string, ImageF>> channels;
  for (std::size_t i = 0; i < decode.directions.size(); ++i) {
    const DirectionDecode& d = decode.directions[i];
    for (std::size_t p = 0; p < d.wrapped_rad.size(); ++p)
      channels.emplace_back(wrapped_channel_name(d.axis, d.pitches_px[p]), d.wrapped_rad[p]);
    if (d.unwrapped && !d.coordinate_px.empty())
      channels.emplace_back(d.axis == Axis::x ? "column_px" : "row_px", to_float(d.coordinate_px));
    const std::string suffix = i == 0 ? "" : std::string("_") + axis_name(d.axis);
    if (d.amplitude_dn.empty()) continue;
    const std::size_t finest = d.wrapped_rad.empty() ? 0 : static_cast<std::size_t>(d.finest);
    channels.emplace_back("amplitude_dn" + suffix, masked_by_validity(d.amplitude_dn[finest], d));
    channels.emplace_back("mean_dn" + suffix, masked_by_validity(d.mean_dn, d));
    channels.emplace_back("sigma_rad" + suffix, masked_by_validity(d.sigma_rad, d));
  }
  return channels;
}

void write_phase_exr(const std::filesystem::path& dir, const CameraDecode& decode) {
  const auto channels = phase_channels(decode);
  std::vector<NamedChannel> named;
  for (const auto& [name, image] : channels) named.emplace_back(name, &image);
  write_exr(dir / ("phase_" + decode.camera + ".exr"), named);
}

}  // namespace fringetwin::measure
