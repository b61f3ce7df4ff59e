// SPDX-License-Identifier: Apache-2.0
// Baseline and angle of triangulation of a device beside the first camera: takes the poses of both, and
// returns the two numbers, or the device's pose with one of them changed.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "twin/lens/pose.hpp"

namespace fringetwin {

/// Returns the distance of two devices' centres, mm.
double baseline_mm(const Pose& T_first_world, const Pose& T_device_world);

/// Returns where a device aims (world frame): the point of its optical axis that is nearest to the first
/// camera's. nullopt where the axes are parallel to a thousandth of a radian, or that point is not in front
/// of it.
std::optional<Eigen::Vector3d> aim_mm(const Pose& T_first_world, const Pose& T_device_world);

/// Returns the angle between the ways from where the device aims to the first camera and to the device, rad;
/// nullopt where it aims nowhere.
std::optional<double> triangulation_rad(const Pose& T_first_world, const Pose& T_device_world);

/// Returns the device's pose after it has moved along the line of both centres until they are `baseline_mm`
/// apart, turned by the smallest rotation that lets it aim at the same point as before; one that aims nowhere
/// is not turned. nullopt where both stand at one place, or it would get to within a thousandth of a
/// millimetre of where it aims.
std::optional<Pose> with_baseline(const Pose& T_first_world, const Pose& T_device_world, double baseline_mm);

/// Returns the device's pose after a rigid turn about where it aims, in the plane of that point and both
/// centres, until the ways from that point to both make `angle_rad`. nullopt where it aims nowhere, or these
/// three lie on one line. Where the axes do not meet, the turned device aims at another point, at which the
/// angle is a little another one: done again, it is not the same.
std::optional<Pose> with_triangulation(const Pose& T_first_world, const Pose& T_device_world,
                                       double angle_rad);

}  // namespace fringetwin
