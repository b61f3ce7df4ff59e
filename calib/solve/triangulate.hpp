// SPDX-License-Identifier: Apache-2.0
// Triangulates points from their pixels in the devices of a calibrated rig (least squares), and measures how
// far two point sets differ after a rigid alignment.
#pragma once
#include <optional>
#include <vector>

#include "calib/solve/calibration.hpp"

namespace fringetwin::calib {

/// The point (mm, reference frame) whose projections come nearest to q_px[d] in every device (sum of squared
/// pixel differences); nullopt when a projection fails or the iteration from `start` does not settle.
std::optional<Eigen::Vector3d> triangulate(const std::vector<Lens>& lenses,
                                           const std::vector<Pose>& T_device_ref,
                                           const std::vector<Eigen::Vector2d>& q_px,
                                           const Eigen::Vector3d& start_mm);

/// rms distance after the best rigid motion (Kabsch). Needs 3 points.
double aligned_rms_mm(const std::vector<Eigen::Vector3d>& a_mm, const std::vector<Eigen::Vector3d>& b_mm);

}  // namespace fringetwin::calib
