// SPDX-License-Identifier: Apache-2.0
// Where a ray meets an analytic shape, in double precision; one file per shape. A mesh is met in its own
// frame (reference_mesh.hpp).
#pragma once
#include <Eigen/Core>
#include <optional>

#include "twin/twin.hpp"

namespace fringetwin::render {

struct Ray {
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit
};

struct ShapeHit {
  double t_mm = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, the shape's own (outward) side
};

/// Returns the nearest hit with t_min < t < t_max.
std::optional<ShapeHit> intersect(const SphereShape& sphere, const Ray& ray, double t_min, double t_max);
std::optional<ShapeHit> intersect(const PlaneShape& plane, const Ray& ray, double t_min, double t_max);
std::optional<ShapeHit> intersect(const CylinderShape& cylinder, const Ray& ray, double t_min, double t_max);

/// Returns whether a ray that leaves a point of the shape towards the light can meet the same shape again:
/// `lit_outside` says that it leaves on the shape's outer side. A cylinder seen from within can.
bool meets_own_shadow_ray(const SphereShape& sphere, bool lit_outside);
bool meets_own_shadow_ray(const PlaneShape& plane, bool lit_outside);
bool meets_own_shadow_ray(const CylinderShape& cylinder, bool lit_outside);

}  // namespace fringetwin::render
