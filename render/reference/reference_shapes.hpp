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

/// Declares, for the shape S in a file of its own,
/// - intersect(): returns the nearest hit with t_min < t < t_max;
/// - meets_own_shadow_ray(): returns whether a ray that leaves a point of the shape towards the light can
/// meet
///   the same shape again; `lit_outside` says that it leaves on the shape's outer side. A cylinder seen from
///   within can.
#define FT_DECLARE(S)                                                                            \
  std::optional<ShapeHit> intersect(const S& shape, const Ray& ray, double t_min, double t_max); \
  bool meets_own_shadow_ray(const S& shape, bool lit_outside);
FT_ANALYTIC_SHAPES(FT_DECLARE)
#undef FT_DECLARE

}  // namespace fringetwin::render
