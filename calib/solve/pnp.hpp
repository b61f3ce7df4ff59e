// SPDX-License-Identifier: Apache-2.0
// Returns the pose of the board in one device, from the corners of one view.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib/board/observations.hpp"
#include "twin/lens/mrcal_facade.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::calib {

/// Holds a pose and how well it fits.
struct BoardPose {
  Pose T_device_board;
  double rms_normalized = 0.0;  ///< of the reprojection, in units of x/z (radians near the axis)
};

/// Solves perspective-n-point by IPPE (Collins and Bartoli, "Infinitesimal plane-based pose estimation", IJCV
/// 2014) as OpenCV has it, on corners unprojected through the lens; returns that of its two poses which fits
/// better. Corners further than 75 degrees from the axis are left out. nullopt with fewer than 4 usable
/// corners or when no pose has the board in front.
std::optional<BoardPose> board_pose(const Board& board, const std::vector<Corner>& corners,
                                    const MrcalModel& model, const std::vector<double>& intrinsics);

}  // namespace fringetwin::calib
