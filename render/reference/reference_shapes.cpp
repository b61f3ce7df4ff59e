// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_shapes.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace fringetwin::render {

// Haines, Günther, Akenine-Möller, "Precision improvements for ray/sphere intersection", Ray Tracing
// Gems (2019), ch. 7: the discriminant from the closest point, not from a difference of squares.
std::optional<ShapeHit> intersect(const SphereShape& sphere, const Ray& ray, double t_min, double t_max) {
  const Eigen::Vector3d from_center = ray.origin_mm - sphere.center_mm;
  const double along = -from_center.dot(ray.direction);
  const Eigen::Vector3d closest = from_center + along * ray.direction;
  const double h2 = sphere.radius_mm * sphere.radius_mm - closest.squaredNorm();
  if (h2 < 0.0) return std::nullopt;
  const double h = std::sqrt(h2);
  for (double t : {along - h, along + h})
    if (t > t_min && t < t_max)
      return ShapeHit{t, ((from_center + t * ray.direction) / sphere.radius_mm).normalized()};
  return std::nullopt;
}

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

}  // namespace fringetwin::render
