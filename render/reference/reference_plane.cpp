// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>

#include "render/reference/reference_shapes.hpp"

namespace fringetwin::render {

std::optional<ShapeHit> intersect(const PlaneShape& plane, const Ray& ray, double t_min, double t_max) {
  const double slope = plane.normal.dot(ray.direction);
  if (slope == 0.0) return std::nullopt;
  const double t = plane.normal.dot(plane.point_mm - ray.origin_mm) / slope;
  if (!(t > t_min && t < t_max)) return std::nullopt;
  if (plane.size_mm) {
    const Eigen::Vector3d in_plane = ray.origin_mm + t * ray.direction - plane.point_mm;
    const Eigen::Vector3d v_axis = plane.normal.cross(plane.u_axis);
    if (std::abs(in_plane.dot(plane.u_axis)) > 0.5 * plane.size_mm->x() ||
        std::abs(in_plane.dot(v_axis)) > 0.5 * plane.size_mm->y())
      return std::nullopt;
  }
  return ShapeHit{t, plane.normal};
}

bool meets_own_shadow_ray(const PlaneShape&, bool) { return false; }

}  // namespace fringetwin::render
