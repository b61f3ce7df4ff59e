// SPDX-License-Identifier: Apache-2.0
// What a twin leaves of gray values, with the coordinates that it may follow.
#pragma once
#include <string>
#include <vector>

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

}  // namespace fringetwin::compare
