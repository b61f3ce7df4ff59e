// SPDX-License-Identifier: Apache-2.0
// The curve of a camera's gray values over the light: DN = black_level_dn + f(gain_dn E)
// (docs/PHYSICS.md, "The camera's response").
#pragma once
#include <vector>

namespace fringetwin {

/// f, straight between corners: slope 1 from the origin to the first corner, so that gain_dn stays the slope
/// at the origin; `last_slope` beyond the last one. Rises everywhere.
struct CameraResponse {
  struct Corner {
    double in_dn = 0.0, out_dn = 0.0;  ///< gain_dn E, and what the sensor gives above black
  };
  std::vector<Corner> corners;  ///< none: a straight line
  double last_slope = 1.0;

  bool straight() const { return corners.empty(); }
  double operator()(double in_dn) const;
  double inverse(double out_dn) const;
  /// Returns f' at this input; at a corner that of what follows.
  double slope(double in_dn) const;
  /// Returns the largest slope.
  double steepest() const;
  /// Returns the same curve in another unit of gray values, `scale` of them for each of now.
  CameraResponse scaled(double scale) const;
};

/// Returns the response that is straight up to a knee and has this slope beyond it.
inline CameraResponse knee_response(double knee_dn, double slope) { return {{{knee_dn, knee_dn}}, slope}; }

}  // namespace fringetwin
