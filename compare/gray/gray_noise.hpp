// SPDX-License-Identifier: Apache-2.0
// Predicts the variance of a real gray value from its level, by the best estimate that a comparison has: the
// images themselves, the sensor model of the twin, or rounding alone.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compare/gray/dark_noise.hpp"
#include "compare/gray/gray_pair.hpp"
#include "measure/decode/decode.hpp"
#include "measure/decode/phase_noise.hpp"

namespace fringetwin::compare {

/// How well a noise variance is taken to be known that the twin states, and one that the images' steps tell,
/// besides what the fit of its line leaves: no sensor's noise is a line to better than that.
inline constexpr double kStatedKnownTo = 0.05, kMeasuredKnownTo = 0.01;

/// Holds the gray-value variance over the value's own level, whatever noise the decode was told: from the
/// redundancy of the real images' own N steps wherever N > 3; with three steps from the differences between
/// the means of their pitches; else the twin's sensor model; else rounding. Where a code beside the steps
/// tells the noise of dark values, the line is held by it, too. One pitch of three steps tells an upper bound
/// only, since texture may be in it: that is for NoiseRow.
class GrayNoise {
 public:
  /// `real`: decode of the real images, may be null. `use_steps`: phase steps compared, empty = all.
  GrayNoise(const GrayPair& pair, const measure::CameraDecode* real, const std::vector<int>& use_steps);

  /// Returns the variance at this level in DN^2, rounding of both sides included.
  double variance(double gray_dn) const;
  /// Returns the part of it that rounding to whole gray values leaves.
  double rounding_dn2() const;
  /// Returns the relative standard uncertainty of the variance, on average over the pixels' mean gray values.
  double known_to() const { return known_to_; }
  /// The same of single values of these levels, which lie farther from where a line was fitted than the
  /// means.
  double known_to(const std::vector<float>& levels) const;
  const std::string& source() const { return source_; }
  /// Returns true where the images or the twin's sensor model say more than rounding.
  bool known() const { return measured() || sensor_.has_noise(); }
  /// Returns true where the variance was taken from the images themselves.
  bool measured() const { return measured_.has_value(); }
  /// Returns true where the variance is what the twin says of its sensor.
  bool stated() const { return !measured_ && sensor_.has_noise(); }

 private:
  /// Takes the noise from the first direction that has enough pixels: it is one sensor.
  void estimate(const GrayPair& pair, const measure::CameraDecode& real, const std::vector<int>& steps,
                int steps_total);
  /// Holds the line of the steps' noise by that of the dark values of a code, too, where there is one and the
  /// two agree: the steps alone tell it badly there. Where they do not, it is the least that dark values
  /// have.
  void take_dark(const GrayPair& pair);

  const Sensor& sensor_;
  bool radiance_;
  double added_ = 0.0, known_to_ = kStatedKnownTo;
  std::optional<measure::NoiseModel> measured_;
  std::optional<DarkNoise> dark_;
  std::string source_;
};

}  // namespace fringetwin::compare
