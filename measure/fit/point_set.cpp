// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/point_set.hpp"

#include <algorithm>

namespace fringetwin::measure {

CentredPoints::CentredPoints(const std::vector<Eigen::Vector3d>& points_mm) : p_mm(points_mm) {
  for (const Eigen::Vector3d& p : points_mm) centroid_mm += p;
  if (!points_mm.empty()) centroid_mm /= static_cast<double>(points_mm.size());
  for (Eigen::Vector3d& p : p_mm) {
    p -= centroid_mm;
    extent_mm = std::max(extent_mm, p.norm());
  }
  finite = centroid_mm.allFinite();
}

bool check_points(const CentredPoints& points, std::size_t parameters, const std::string& shape,
                  FitSummary& fit) {
  fit.n = points.p_mm.size();
  if (fit.n < parameters) {
    fit.message = "only " + std::to_string(fit.n) + " points: " + shape + " needs at least " +
                  std::to_string(parameters);
    return false;
  }
  if (!points.finite) {
    fit.message = "a point is not finite";
    return false;
  }
  if (points.extent_mm <= points.rounding_mm()) {
    fit.message = "all points are equal: they do not determine " + shape;
    return false;
  }
  return true;
}

}  // namespace fringetwin::measure
