// SPDX-License-Identifier: Apache-2.0
#include "twin/lens/pose.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace fringetwin {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d K;
  K << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return K;
}

}  // namespace

Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& r_rad) {
  // R = I + sin(a)/a K + (1 - cos(a))/a^2 K^2 with 1 - cos(a) = 2 sin^2(a/2): no cancellation.
  const double a = r_rad.stableNorm();
  double sin_over_a = 1.0, versine_over_a2 = 0.5;  // first terms of the series; next is a^2/6 < 1e-17
  if (a > 1e-9) {
    const double half = std::sin(0.5 * a) / a;
    sin_over_a = std::sin(a) / a;
    versine_over_a2 = 2.0 * half * half;
  }
  const Eigen::Matrix3d K = cross_matrix(r_rad);
  return Eigen::Matrix3d::Identity() + sin_over_a * K + versine_over_a2 * (K * K);
}

Eigen::Vector3d vector_from_rotation(const Eigen::Matrix3d& R) {
  // Through the unit quaternion (Shepperd's choice of the largest component, in Eigen): well
  // conditioned at 0 and at pi, where acos of the trace is not.
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sin_half = q.vec().stableNorm();
  if (sin_half == 0.0) return Eigen::Vector3d::Zero();
  return q.vec() * (2.0 * std::atan2(sin_half, q.w()) / sin_half);
}

Pose turned(const Pose& T_a_b, const Eigen::Vector3d& axis_a, double angle_rad,
            const Eigen::Vector3d& about_a_mm) {
  const Eigen::Matrix3d R = rotation_from_vector(angle_rad * axis_a);
  return Pose{R, about_a_mm - R * about_a_mm} * T_a_b;
}

Pose pose_from_rt(const RotTrans& rt) { return {rotation_from_vector(rt.head<3>()), rt.tail<3>()}; }

RotTrans rt_from_pose(const Pose& T) {
  RotTrans rt;
  rt << vector_from_rotation(T.rotation), T.translation_mm;
  return rt;
}

}  // namespace fringetwin
