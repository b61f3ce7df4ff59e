// SPDX-License-Identifier: Apache-2.0
// Says what the gray values that a twin does not explain follow: gray level, phase of the fringes, image
// number, radius, place, or phase from place to place or from image to image (docs/metrics/causes.md,
// "Causes").
#pragma once
#include <string>
#include <vector>

#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// What is left of one gray value, and where that value stands.
struct LeftValue {
  float sigmas = 0.0F;     ///< real - predicted, in standard deviations of the value
  float level_dn = 0.0F;   ///< as predicted: a measured level would follow its own noise
  float phase_rad = 0.0F;  ///< of the fringes there and in this image, 0 where they are brightest; NaN: none
  float x_px = 0.0F, y_px = 0.0F;  ///< of the camera
  int image = 0;                   ///< in the sequence
};

/// The values of one camera.
struct LeftOver {
  std::string camera;
  double middle_x_px = 0.0, middle_y_px = 0.0;  ///< of its image
  std::vector<LeftValue> values;
};

/// Returns a row for each coordinate. `excess`: of chi2 beyond noise, what the shares are of.
std::vector<PatternRow> find_pattern(const std::vector<LeftOver>& cameras, double excess);

/// Says in one sentence what is left follows, or that no pattern was found; empty without rows.
std::string pattern_sentence(const std::vector<PatternRow>& rows);

}  // namespace fringetwin::compare
