// SPDX-License-Identifier: Apache-2.0
// Solves for the depth along a camera ray at which a second device sees given coordinates: the equation
// behind both triangulations. d = unit ray of camera 0; p(s) = R (s d) + t in the second device's frame.
#pragma once
#include <Eigen/Core>

#include "measure/points/coordinate_map.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::measure {

/// One measured coordinate and its noise (0 = unknown).
struct CoordinateTarget {
  double coordinate_px = 0.0;
  double sigma_px = 0.0;
};

struct DepthSolution {
  double depth_mm = 0.0;
  double sigma_mm = 0.0;                           ///< |ds/dcoordinate| times the noise; 0 when unknown
  double residual_px = 0.0;                        ///< rms of the equations at the solution (0 with one)
  Eigen::Vector2d q_px = Eigen::Vector2d::Zero();  ///< pixel of the second device
  Eigen::Vector3d p_mm = Eigen::Vector3d::Zero();  ///< point in the second device's frame
};

enum class SolveStatus {
  ok,
  outside,  ///< left the valid part of the map or the lens
  failed    ///< no convergence
};

/// Finds s by Newton's method for maps seen by a second camera (`maps` has `count` = 1 or 2 coordinate maps);
/// with two, least squares weighted by the noise of both sides.
SolveStatus solve_depth_in_maps(const Lens& lens, const Pose& T_device_cam, const Eigen::Vector3d& d_cam,
                                const CoordinateMap* const* maps, const CoordinateTarget* targets, int count,
                                double start_mm, DepthSolution& out);

/// Finds s by Newton's method for a projector, whose coordinate is its own pixel position: axes[k] 0 =
/// column, 1 = row.
SolveStatus solve_depth_in_projector(const Lens& lens, const Pose& T_device_cam, const Eigen::Vector3d& d_cam,
                                     const int* axes, const CoordinateTarget* targets, int count,
                                     double start_mm, DepthSolution& out);

}  // namespace fringetwin::measure
