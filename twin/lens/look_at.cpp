// SPDX-License-Identifier: Apache-2.0
#include "twin/lens/look_at.hpp"

#include <Eigen/Geometry>

namespace fringetwin {

std::optional<Pose> look_at_pose(const Eigen::Vector3d& position_mm, const Eigen::Vector3d& look_at_mm,
                                 const Eigen::Vector3d& up) {
  constexpr double kLeastDistanceMm = 1e-3, kLeastAngle = 1e-3;
  const Eigen::Vector3d along = look_at_mm - position_mm;
  if (!(along.norm() >= kLeastDistanceMm) || !(up.norm() > 0.0)) return std::nullopt;
  const Eigen::Vector3d z = along.stableNormalized(), right = (-up.stableNormalized()).cross(z);
  if (!(right.norm() >= kLeastAngle)) return std::nullopt;
  const Eigen::Vector3d x = right.normalized();
  Pose pose;
  pose.rotation.row(0) = x;
  pose.rotation.row(1) = z.cross(x);
  pose.rotation.row(2) = z;
  pose.translation_mm = -(pose.rotation * position_mm);
  return pose;
}

}  // namespace fringetwin
