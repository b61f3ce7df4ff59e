// SPDX-License-Identifier: Apache-2.0
// Ray against analytic shapes in double precision.
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

/// The nearest hit with t_min < t < t_max.
std::optional<ShapeHit> intersect(const SphereShape& sphere, const Ray& ray, double t_min, double t_max);
std::optional<ShapeHit> intersect(const PlaneShape& plane, const Ray& ray, double t_min, double t_max);
std::optional<ShapeHit> intersect(const CylinderShape& cylinder, const Ray& ray, double t_min, double t_max);

}  // namespace fringetwin::render
