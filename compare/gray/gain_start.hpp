// SPDX-License-Identifier: Apache-2.0
// Makes the line that the fit of a camera's gain starts from: a pair of image stacks goes in, gain and black
// level from the brightness that each pixel sweeps in them comes out.
#pragma once
#include <cstddef>
#include <optional>

#include "compare/gray/gray_noise.hpp"
#include "compare/gray/gray_pair.hpp"

namespace fringetwin::compare {

/// A line that holds no phase: every pixel has the ratio of its real to its simulated amplitude, whatever
/// lies where, so a wrong pose hardly moves it and half of the pixels may have another reflectivity.
struct GainStart {
  double gain_dn = 0.0;         ///< median of the ratios
  double black_level_dn = 0.0;  ///< median of what each pixel's own ratio leaves of its mean
  double spread = 0.0;          ///< robust relative scatter of the ratios
  double outlier_share = 0.0;   ///< pixels beyond ten spreads, and beyond a fifth
  std::size_t n_pixels = 0;
  /// Returns whether the ratios differ by more than one gain for all pixels allows.
  bool scatters() const { return spread > 0.1 || outlier_share > 0.02; }
};

/// Returns the line of at most 20,000 evenly spread pixels of the mask, none of whose values is clipped on
/// either side; nothing where fewer than 50 are left or the irradiance does not vary. The amplitude is the
/// standard deviation over the images that the gain is fitted on, less the part that is noise.
std::optional<GainStart> start_of_amplitudes(const GrayPair& pair, const GrayNoise* noise);

}  // namespace fringetwin::compare
