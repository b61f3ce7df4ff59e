// SPDX-License-Identifier: Apache-2.0
// Takes where a device stands, what it looks at and which way is up, and returns its pose.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "twin/lens/pose.hpp"

namespace fringetwin {

/// Up where nobody says otherwise: with it a device at the origin that looks along +z has the identity as its
/// pose, as the first camera has.
inline const Eigen::Vector3d kUpByDefault{0.0, -1.0, 0.0};

/// Returns T_device_world of a device at `position_mm` whose optical axis passes through `look_at_mm` and
/// whose image has `up` (world frame, any length) upwards, without tilt to the side. nullopt where the two
/// points are closer than a thousandth of a millimetre, or `up` lies within a thousandth of a radian of the
/// optical axis or is zero.
std::optional<Pose> look_at_pose(const Eigen::Vector3d& position_mm, const Eigen::Vector3d& look_at_mm,
                                 const Eigen::Vector3d& up = kUpByDefault);

}  // namespace fringetwin
