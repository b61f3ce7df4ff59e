// SPDX-License-Identifier: Apache-2.0
// Tells at which levels a camera's curve bends the light of samples whose pixels, or images, have numbers of
// their own that no twin holds (docs/metrics/causes.md, "Refinement").
#pragma once
#include <vector>

#include "compare/parameters/grid_view.hpp"
#include "compare/result/own_kinds.hpp"

namespace fringetwin::compare {

/// The level of each value: light_k (factor E + offset exposure_k) of its irradiance E, in its unit; light_k
/// of an image lit apart, factor and offset of a pixel by least squares through its real values.
class OwnLevels {
 public:
  /// The level is the irradiance.
  OwnLevels() = default;
  /// `irradiance` is predicted and `real` what the real gray values ask for (real_light()), both before a
  /// camera's curve or both after it, laid out as GridSamples::real_dn. `exposures`: of the images; empty: 1.
  /// Where nothing is free per pixel, `real` is not looked at.
  OwnLevels(const GridSamples& samples, const std::vector<float>& irradiance, const std::vector<float>& real,
            FreePerPixel free, const std::vector<double>& exposures);

  /// Turns irradiance into levels.
  void to_levels(std::vector<float>& values) const;
  /// Turns levels into irradiance.
  void to_irradiance(std::vector<float>& values) const;

 private:
  std::vector<float> factor_, offset_;  ///< of each value; empty: 1 and 0
};

/// Returns the irradiance that the real gray values ask for at the gain and black level of the samples, with
/// nothing of a pixel's or an image's own taken out.
std::vector<float> real_light(const GridSamples& samples);

}  // namespace fringetwin::compare
