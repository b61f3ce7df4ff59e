// SPDX-License-Identifier: Apache-2.0
// What decoding takes and what it makes of the images of one camera: wrapped phases, absolute projector
// coordinates and their sigmas, and why a pixel has none.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "measure/light/light_factors.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/fringes.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::measure {

/// Why a pixel is not valid (bit flags).
enum PixelFlag : unsigned char {
  kValid = 0,
  kSaturated = 1,
  kLowModulation = 2,
  kOrderInvalid = 4,  ///< residual of the unwrapping too large, or coordinate outside the projector
};
inline constexpr unsigned kUnseen =
    kSaturated | kLowModulation;  ///< flags of pixels without fringes to measure

/// Radiance images have no DN: this share of the 99.9 percentile of the amplitude is their smallest one.
inline constexpr double kRadianceModulation = 1e-3;

struct DecodeOptions {
  /// Smallest amplitude (half of bright minus dark) at any pitch; code only: half of white - black (or of
  /// the largest pattern - inverse). Radiance images have kRadianceModulation in its place.
  double min_modulation_dn = 5.0;
  /// Code only: smallest |pattern - inverse| (2 |value - threshold| without pairs) of every bit.
  double min_bit_difference_dn = 5.0;
  /// Phase steps used (subset of 0...N-1); empty = all. At least 3.
  std::vector<int> use_steps;
  /// Known sensor noise of a gray value, var = a + b*DN in DN^2 without the rounding (which adds 1/12);
  /// else it is estimated from the N-step residuals (N > 3), or quantisation only.
  std::optional<double> variance_offset_dn2, variance_per_dn;
  /// That line is never followed below this (read noise: below the black level no shot noise is left to
  /// take away).
  double least_variance_dn2 = 0.0;
  /// Size of the projector image along x/y when known: coordinates outside [-0.5, size-0.5) are invalid.
  std::optional<double> projector_width_px, projector_height_px;
  /// When set, the light of the images is estimated (estimate_light) and taken out of what is above black
  /// before anything else, where it differs by more than chance.
  std::optional<LightOptions> light;
  bool repair_orders = true;  ///< false: n_left still counts the jumps
  bool operator==(const DecodeOptions&) const = default;
};

/// What fringe-order repair changed, always reported.
struct OrderRepair {
  std::uint64_t n_checked = 0;  ///< valid pixels looked at
  std::uint64_t n_changed = 0;  ///< moved by a whole period
  std::uint64_t n_left = 0;     ///< jumps that remain between valid 4-neighbours (not at occlusions)
};

/// Where the gray-value noise behind sigma_rad comes from.
enum class NoiseSource { known, residuals, quantisation };

struct DirectionDecode {
  Axis axis = Axis::x;
  bool unwrapped = true;  ///< false: unwrap = "none", coordinate_px is NaN throughout
  std::vector<double> pitches_px;
  int finest = 0;                    ///< index of the smallest pitch
  std::vector<ImageF> wrapped_rad;   ///< per pitch, (-pi, pi]; NaN where saturated or the modulation is
                                     ///< too low at that pitch; empty for code only
  std::vector<ImageF> amplitude_dn;  ///< per pitch (code only: one, of the code), finite everywhere
  ImageF mean_dn;                    ///< finest pitch
  ImageF sigma_rad;                  ///< predicted phase sigma, finest pitch
  ImageD coordinate_px;              ///< absolute projector coordinate; NaN where invalid
  ImageF coordinate_sigma_px;
  bool smoothed = false;  ///< by smooth_coordinates(): neighbours share their noise
  OrderRepair repair;
  NoiseSource noise_source = NoiseSource::quantisation;
  double noise_dn = 0.0;  ///< rms noise of a gray value behind sigma_rad, median over the valid pixels
  /// Relative standard error of its variance that the estimate from residuals leaves; 0 for other sources.
  double noise_known_to = 0.0;
};

struct CameraDecode {
  std::string camera;
  std::vector<DirectionDecode> directions;
  ImageU8 flags;             ///< PixelFlag, all directions or-ed
  std::optional<Clip> clip;  ///< of the images, where they stop below full scale
  bool radiance = false;     ///< the images were radiance: amplitudes and means are no DN
  /// What DecodeOptions::light found; nothing where the steps do not tell.
  std::optional<LightFactors> light;
  bool light_taken_out = false;
  int width() const { return flags.width; }
  int height() const { return flags.height; }
  const DirectionDecode* direction(Axis axis) const;
};

}  // namespace fringetwin::measure
