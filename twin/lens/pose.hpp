// SPDX-License-Identifier: Apache-2.0
// Rigid transforms between frames: T_a_b maps a point written in frame b to frame a (docs/CONVENTIONS.md).
#pragma once
#include <Eigen/Core>

namespace fringetwin {

/// Rotation vector (Rodrigues, rad) then translation (mm): x_a = R(r) x_b + t.
using RotTrans = Eigen::Matrix<double, 6, 1>;

/// x_a = rotation * x_b + translation_mm.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& p_b_mm) const {
    return rotation * p_b_mm + translation_mm;
  }
  /// Returns T_a_c = T_a_b * T_b_c.
  Pose operator*(const Pose& T_b_c) const {
    return {rotation * T_b_c.rotation, rotation * T_b_c.translation_mm + translation_mm};
  }
  Pose inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation_mm)}; }
};

/// Returns the rotation of a rotation vector by Rodrigues' formula, series near zero; exact to double
/// rounding for every angle.
Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& r_rad);
/// Returns the rotation vector of a rotation, |r| in [0, pi].
Eigen::Vector3d vector_from_rotation(const Eigen::Matrix3d& R);

/// Returns T_a_b after a turn by `angle_rad` about an axis of frame a through a point written in a.
Pose turned(const Pose& T_a_b, const Eigen::Vector3d& axis_a, double angle_rad,
            const Eigen::Vector3d& about_a_mm);

Pose pose_from_rt(const RotTrans& rt);
RotTrans rt_from_pose(const Pose& T);

}  // namespace fringetwin
