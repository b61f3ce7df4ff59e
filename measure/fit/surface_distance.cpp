// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "measure/fit/closest_point.hpp"
#include "measure/fit/fits.hpp"

namespace fringetwin::measure {
namespace {

double distance(const SphereShape& s, const Eigen::Vector3d& p) {
  return (p - s.center_mm).norm() - s.radius_mm;
}

double distance(const PlaneShape& s, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = p - s.point_mm;
  const double height = s.normal.dot(d);
  if (!s.size_mm) return height;
  const double u = std::abs(s.u_axis.dot(d)) - 0.5 * s.size_mm->x();
  const double v = std::abs(s.normal.cross(s.u_axis).dot(d)) - 0.5 * s.size_mm->y();
  const double beside = std::hypot(std::max(u, 0.0), std::max(v, 0.0));
  return std::copysign(std::hypot(height, beside), height);
}

double distance(const CylinderShape& s, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = p - s.point_mm;
  const double along = s.axis.dot(d);
  const double radial = (d - along * s.axis).norm() - s.radius_mm;
  if (!s.length_mm) return radial;
  return std::copysign(std::hypot(radial, std::max(std::abs(along) - 0.5 * *s.length_mm, 0.0)), radial);
}

double distance(const MeshShape& s, const Eigen::Vector3d& p) {
  return mesh_distance_for(s.mesh)->query(s.T_world_object.inverse() * p).signed_distance_mm;
}

double distance(const MeasuredShape&, const Eigen::Vector3d&) {
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

double surface_distance_mm(const Object& object, const Eigen::Vector3d& p_world_mm) {
  return std::visit([&](const auto& shape) { return distance(shape, p_world_mm); }, object.shape);
}

}  // namespace fringetwin::measure
