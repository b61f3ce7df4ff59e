// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "render/reference/reference_shapes.hpp"

namespace fringetwin::render {

std::optional<ShapeHit> intersect(const CylinderShape& cylinder, const Ray& ray, double t_min, double t_max) {
  const Eigen::Vector3d& axis = cylinder.axis;
  const Eigen::Vector3d from_point = ray.origin_mm - cylinder.point_mm;
  const Eigen::Vector3d across = from_point - axis.dot(from_point) * axis;
  const Eigen::Vector3d direction = ray.direction - axis.dot(ray.direction) * axis;
  const double speed2 = direction.squaredNorm();
  if (speed2 == 0.0) return std::nullopt;
  const double nearest = -across.dot(direction) / speed2;
  const Eigen::Vector3d closest = across + nearest * direction;
  const double h2 = (cylinder.radius_mm * cylinder.radius_mm - closest.squaredNorm()) / speed2;
  if (h2 < 0.0) return std::nullopt;
  const double h = std::sqrt(h2);
  for (double t : {nearest - h, nearest + h}) {
    if (!(t > t_min && t < t_max)) continue;
    if (cylinder.length_mm && std::abs(axis.dot(from_point + t * ray.direction)) > 0.5 * *cylinder.length_mm)
      continue;
    return ShapeHit{t, (across + t * direction).normalized()};
  }
  return std::nullopt;
}

bool meets_own_shadow_ray(const CylinderShape&, bool lit_outside) { return !lit_outside; }

}  // namespace fringetwin::render
