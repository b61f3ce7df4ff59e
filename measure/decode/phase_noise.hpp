// SPDX-License-Identifier: Apache-2.0
// Models the noise of a gray value as a function of its level, known or estimated from the N-step residuals.
#pragma once
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "measure/decode/phase.hpp"
#include "measure/decode/stripe_harmonics.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::measure {

/// Holds the variance of one gray value as a line over its level (photon transfer), with the variance that it
/// never falls below: quantisation.
struct NoiseModel {
  double offset = 0.0, per_unit = 0.0, least = 0.0;
  /// Where the line was fitted: its errors at this level and in its slope are independent.
  double level = 0.0, height_sigma = 0.0, slope_sigma = 0.0;

  double variance(double at) const { return std::max(offset + per_unit * at, least); }
  /// Returns the standard error that the fit of the line leaves in a mean of squares over the variances of
  /// these levels: relative, and common to all of them.
  double known_to(const std::vector<float>& levels) const;
};

/// The cut of noise, in sigmas (so far out that coarse gray levels, steps of half a sigma, matter little),
/// and the share of the variance of a normal distribution that it leaves: 1 - 2 c phi(c) / (2 Phi(c) - 1).
inline constexpr double kCutSigmas = 3.5, kKeptVariance = 0.99389;
/// Texture: a roughness of more than this many sigmas of what white noise does.
inline constexpr double kRoughSigmas = 4.0;

/// Holds a value of mean 0 whose variance is that of one gray value of this level.
struct NoiseValue {
  float level, value;
  float roughness = 0.0f;  ///< how much the scene's texture varies there, on the value's scale; 0 = unknown
};

/// Says which pixels tell noise.
struct NoiseLimits {
  double min_amplitude = 0.0;
  /// Gray values stop at 0 and here. Infinite for irradiance, whose pixels without light have no noise.
  double saturation = std::numeric_limits<double>::infinity();
  double least = 0.0;  ///< variance: quantisation
};

/// Appends values of pixels without fringes, shadow and background, `together` in a row of one place: there
/// the line's dark end is seen that fringes hold in their valleys only. Left out are places where a clip cuts
/// the noise, and all where rounding hides it. Returns the middle level of those; -infinity without any.
double add_unlit(const std::vector<NoiseValue>& unlit, std::size_t together, const NoiseLimits& limits,
                 std::vector<NoiseValue>& values);

/// Fits the line of the model to the squares of the values by weighted least squares, 1 / variance^2 from the
/// line itself, iterated with a cut: `together` values in a row are of one place, where an outlier in one
/// spoils all. Noise does not fall with the level; at the `darkest` one it is no less than `least` and than
/// what the slope leaves unknown there, so that no slope is made up. Returns nothing with fewer than 200
/// values.
std::optional<NoiseModel> fit_noise(const std::vector<NoiseValue>& values, std::size_t together,
                                    double darkest, double least);

/// Estimates gray-value noise from the residuals of the N-step fit, N > 3. The steps are differentiated twice
/// along the stripes, which removes the projector's harmonics where the stripes are straight, and what is
/// left of them (StripeHarmonics); of that the N - 3 orthonormal contrasts without mean, cosine and sine,
/// over sqrt(6), are noise alone. A contrast c has the variance sum c_k^2 v_k of the steps' own variances:
/// where v is linear in the level, that of the level sum c_k^2 I_k of the steps I themselves: with a gamma
/// they are no sinusoid. Pixels without fringes take part, at most as many as with. Returns nothing when
/// there are too few pixels for fit_noise().
std::optional<NoiseModel> estimate_noise(const std::vector<NoiseInput>& pitches, const StepSolver& solver,
                                         Axis axis, const NoiseLimits& limits);

}  // namespace fringetwin::measure
