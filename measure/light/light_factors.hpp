// SPDX-License-Identifier: Apache-2.0
// Estimates from the phase steps of one camera what light each image got: a lamp that flickers or drifts, an
// exposure that is not kept (docs/metrics/measure.md, "Light of the images").
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/fringes.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// Phase steps of a pitch that tell the light: three leave nothing over, and more than 64 are not looked at.
inline constexpr int kFewestLightSteps = 4, kMostLightSteps = 64;

/// Says which pixels tell the light, and what they weigh.
struct LightOptions {
  double black_level_dn = 0.0;  ///< what a pixel shows without any light
  double min_amplitude = 5.0;   ///< of a fringe that counts
  /// Variance of a gray value, var = a + b DN; its scale does not matter.
  double variance_offset_dn2 = 1.0, variance_per_dn = 0.0;
  /// Whether shifts of the fringes from image to image are told, too (six steps or more).
  bool with_shifts = false;
  /// Returns one over the variance of gray values of this mean level over black.
  double weight(double over_black_dn) const;
  bool operator==(const LightOptions&) const = default;
};

/// Returns those of a camera's gray values: its black level, and the noise that its sensor states, with the
/// rounding.
LightOptions light_options(const Sensor& sensor, double min_modulation_dn);

/// Holds the factors of one camera's images: I = black + factor * (what a steady light would show).
struct LightFactors {
  /// Per image of the sequence, geometric mean 1 over the phase steps; 1 of all else, and of steps that were
  /// not asked.
  std::vector<double> factor;
  /// Relative standard errors; 0 of what is no phase step or was not asked, infinite where none can be told.
  std::vector<double> sigma;
  /// Of each pitch, in the order of the sequence: cosine and sine of the harmonics 2, 3 ... that its fringes
  /// have besides their cosine, over the amplitude; empty where it is not told.
  std::vector<std::vector<double>> waveform = {};
  /// Per image: what its fringes are ahead of their step, rad, and the standard errors, where they were asked
  /// for; 0 of what is no phase step. Of each pitch without the mean and the first harmonic of its steps,
  /// which the phases and the factors hold.
  std::vector<double> shift_rad = {}, shift_sigma_rad = {};
  /// Mean square of the residuals of the N-step fits per degree of freedom, with a steady light and with
  /// these factors, DN^2 (times 1/var where the options have a line). Harmonics of the fringe stay out of
  /// both.
  double residual_before = 0.0, residual_after = 0.0;
  std::size_t n_pixels = 0;  ///< that told it, all pitches
  /// Rms phase that the factors move, largest of all pitches (light_phase_rms_rad()).
  /// NaN where not all steps were asked.
  double phase_rms_rad = 0.0;
  std::vector<int> steps = {};  ///< that told it; empty: all
  /// Returns whether a factor differs from 1 by more than chance lets the farthest of them.
  bool differ() const;
  /// The same of the shifts and 0.
  bool are_shifted() const;
};

/// Returns the largest of standard errors of factors but those that are infinite; infinity where none is
/// told.
double largest_told(const std::vector<double>& sigma);

/// Returns the rms over all phases of what factors 1 + e_k of the N steps of a pitch move the phase by, to
/// first order, where the fringe's mean over black is `mean_over_amplitude` times its amplitude: sqrt(2 |m
/// e_1|^2 + |e_2|^2 / 2) with e_j = (1/N) sum e_k exp(-2 pi i j k/N), m = mean_over_amplitude.
double light_phase_rms_rad(const std::vector<double>& factors_of_steps, double mean_over_amplitude);

/// Estimates the factors from the images alone. Every pixel has its mean, its amplitude and its phase, and
/// the fringes of a pitch have their waveform in common; what the N steps hold besides, N - 3 contrasts of
/// every pixel, is told by N factors common to all pixels (least squares, Huber weights by pixel). Between
/// pitches it is the means that tell. A pitch is not told by fewer than 200 pixels that are lit and not
/// saturated, nor where their phases vary too little: its images keep the factor 1, with an infinite standard
/// error. Returns nothing with other numbers of steps than these, and where the finest pitch of a direction
/// is not told, or any where heterodyne fringes have all of them in the coordinate. `steps`: the steps that
/// are asked, in order; no other image is looked at, and their number N counts. Empty: all. Any number of
/// threads gives the same.
std::optional<LightFactors> estimate_light(const CameraImages& images, const Fringes& fringes,
                                           const LightOptions& options, const std::vector<int>& steps = {});

/// Returns the images with the factors taken out of all that is above black, those of the reference images
/// and of what is no phase step untouched. What was saturated is so afterwards, and nothing else.
CameraImages with_steady_light(CameraImages images, const LightFactors& light, double black_level_dn);

}  // namespace fringetwin::measure
