// SPDX-License-Identifier: Apache-2.0
#include "twin/lens/baseline.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace fringetwin {
namespace {

using Eigen::Vector3d;
constexpr double kLeastDistanceMm = 1e-3, kLeastAngle = 1e-3;

Vector3d center_mm(const Pose& T_device_world) { return T_device_world.inverse().translation_mm; }
Vector3d axis(const Pose& T_device_world) { return T_device_world.rotation.row(2); }
/// Exact for small angles, too.
double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

double baseline_mm(const Pose& T_first_world, const Pose& T_device_world) {
  return (center_mm(T_device_world) - center_mm(T_first_world)).norm();
}

std::optional<Vector3d> aim_mm(const Pose& T_first_world, const Pose& T_device_world) {
  const Vector3d from = center_mm(T_device_world), along = axis(T_device_world), other = axis(T_first_world);
  const Vector3d normal = along.cross(other);
  if (!(normal.norm() >= kLeastAngle)) return std::nullopt;
  const double distance = (center_mm(T_first_world) - from).cross(other).dot(normal) / normal.squaredNorm();
  if (!(distance >= kLeastDistanceMm)) return std::nullopt;
  return Vector3d(from + distance * along);
}

std::optional<double> triangulation_rad(const Pose& T_first_world, const Pose& T_device_world) {
  const auto aim = aim_mm(T_first_world, T_device_world);
  if (!aim) return std::nullopt;
  const Vector3d to_first = center_mm(T_first_world) - *aim, to_device = center_mm(T_device_world) - *aim;
  return angle_between(to_first, to_device);
}

std::optional<Pose> with_baseline(const Pose& T_first_world, const Pose& T_device_world, double baseline_mm) {
  const Vector3d first = center_mm(T_first_world), before = center_mm(T_device_world);
  if (!((before - first).norm() >= kLeastDistanceMm)) return std::nullopt;
  const Vector3d after = first + baseline_mm * (before - first).normalized();
  Pose moved = T_device_world;
  if (const auto aim = aim_mm(T_first_world, T_device_world)) {
    if (!((*aim - after).norm() >= kLeastDistanceMm)) return std::nullopt;
    // from the old direction to the new one, world frame
    const Eigen::Matrix3d turn =
        Eigen::Quaterniond::FromTwoVectors(*aim - before, *aim - after).toRotationMatrix();
    moved.rotation = T_device_world.rotation * turn.transpose();
  }
  moved.translation_mm = -(moved.rotation * after);
  return moved;
}

std::optional<Pose> with_triangulation(const Pose& T_first_world, const Pose& T_device_world,
                                       double angle_rad) {
  const auto aim = aim_mm(T_first_world, T_device_world);
  if (!aim) return std::nullopt;
  const Vector3d to_first = center_mm(T_first_world) - *aim, to_device = center_mm(T_device_world) - *aim;
  const Vector3d normal = to_first.cross(to_device);
  if (!(normal.norm() >= kLeastAngle * to_first.norm() * to_device.norm())) return std::nullopt;
  const double turn_rad = angle_rad - angle_between(to_first, to_device);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(turn_rad, normal.normalized()).toRotationMatrix();
  Pose moved = T_device_world;
  moved.rotation = T_device_world.rotation * turn.transpose();
  moved.translation_mm = -(moved.rotation * (*aim + turn * to_device));
  return moved;
}

}  // namespace fringetwin
