// SPDX-License-Identifier: Apache-2.0
// Splits the gray residual after the gain fit into noise, albedo and shading, projector harmonics, geometry,
// and a rest (docs/metrics/gray.md, "Gray budget").
#pragma once
#include <cstddef>
#include <functional>
#include <optional>

#include "compare/gray/gain_fit.hpp"
#include "compare/gray/gray_noise.hpp"
#include "measure/decode/decode.hpp"

namespace fringetwin::compare {

/// What the noise of a measured shape's normals does to the light of the projector: a shading that is no
/// reflectivity of the part. Without a measured shape there is none.
struct ShadingNoise {
  /// Returns the relative standard error of the projector's light on a pixel; empty: no shape was measured.
  std::function<double(std::size_t pixel)> at;
  double ambient = 0.0;  ///< irradiance of the room, which no normal shades
};

/// Returns the budget of at most 60,000 pixels, evenly spread; nullopt where there are no phase steps or
/// neither side was decoded. The parts are variances removed one after the other, each corrected for the
/// noise a per-pixel parameter removes with it, so that they add up to the total.
std::optional<GrayBudget> gray_budget(const GrayPair& pair, const GainFit& fit,
                                      const measure::CameraDecode* real,
                                      const measure::CameraDecode* simulated, const GrayNoise& noise,
                                      const ShadingNoise& shading = {});

}  // namespace fringetwin::compare
