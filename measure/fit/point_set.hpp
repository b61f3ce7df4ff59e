// SPDX-License-Identifier: Apache-2.0
// Does what every fit does first: moves the points to their centroid (keeps digits far from the origin) and
// refuses sets that cannot determine anything.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "measure/fit/fit_types.hpp"

namespace fringetwin::measure {

struct CentredPoints {
  explicit CentredPoints(const std::vector<Eigen::Vector3d>& points_mm);
  /// Scale below which residuals are rounding of the coordinates.
  double rounding_mm() const { return 64.0 * 2.3e-16 * (centroid_mm.norm() + extent_mm); }
  /// Residuals of 2 ppm of the size are no outliers, however small the others are (ideal simulations).
  double smallest_scale_mm() const { return rounding_mm() + 2e-6 * extent_mm; }

  Eigen::Vector3d centroid_mm = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> p_mm;  ///< minus the centroid
  double extent_mm = 0.0;             ///< largest distance from the centroid
  bool finite = true;
};

/// Returns false, with fit.message, for too few points, NaN, or all points equal.
bool check_points(const CentredPoints& points, std::size_t parameters, const std::string& shape,
                  FitSummary& fit);

}  // namespace fringetwin::measure
