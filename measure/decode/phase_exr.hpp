// SPDX-License-Identifier: Apache-2.0
// Writes a decoded camera as phase_<camera>.exr (docs/formats/results.md, "What measure writes"): float32
// channels, NaN where invalid.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "measure/decode/decode_types.hpp"

namespace fringetwin::measure {

/// Returns the channels: wrapped_<dir>_<pitch> per pitch, column_px and/or row_px (none for unwrap = "none"),
/// amplitude_dn, mean_dn, sigma_rad (finest pitch) of the first direction; a second direction adds
/// amplitude_dn_<dir>, mean_dn_<dir>, sigma_rad_<dir>. Amplitude, mean and sigma are NaN where the
/// finest wrapped phase is (code only: where the coordinate is).
std::vector<std::pair<std::string, ImageF>> phase_channels(const CameraDecode& decode);

/// One of these channels, computed where it is read. The decode must outlive it.
struct PhaseChannel {
  std::string name;
  const ImageF* image = nullptr;  ///< where it holds the channel as it is; else null
  std::function<float(std::size_t)> at;
  std::function<void(std::size_t first, std::span<float> out)> copy;  ///< many values at once
};
std::vector<PhaseChannel> phase_channel_values(const CameraDecode& decode);

/// Writes DIR/phase_<camera>.exr, first under a temporary name.
void write_phase_exr(const std::filesystem::path& dir, const CameraDecode& decode);

/// Returns the name of a channel such as "wrapped_x_13p5": shortest decimal, '.' as 'p'.
std::string wrapped_channel_name(Axis axis, double pitch_px);

}  // namespace fringetwin::measure
