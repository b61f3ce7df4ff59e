// SPDX-License-Identifier: Apache-2.0
// Finds where the joint solve starts: each device is solved alone, in stages from a rough focal length and
// the poses of the boards in its views; then the rig follows from the views that devices share, with the
// check that they see the same corners in the same order.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calib/board/observations.hpp"
#include "calib/solve/problem.hpp"
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

/// One device calibrated alone.
struct AloneFit {
  std::vector<double> intrinsics;
  std::map<int, Pose> T_device_board;  ///< by frame
  std::map<int, double> view_rms_px;   ///< by frame, 2-norm per corner
  double rms_px = 0.0;
};

/// Stages: poses with a stereographic lens of the rough focal length; with its core; the wanted model,
/// started from there and, when it has more than four distortion terms, also from a solved LENSMODEL_OPENCV4
/// (rational terms fall into wrong minima); the better of the two stays. Throws UserError.
AloneFit calibrate_alone(const Observations& observations, int device, const std::string& lensmodel);

/// Poses of devices and boards that agree with each other. Throws UserError(input) naming the view when two
/// devices do not see one board in one place, and why where that can be told: corners in another order, two
/// devices swapped, a board of another size.
Seed seed_rig(const Observations& observations, const std::string& lensmodel,
              const std::vector<AloneFit>& alone);

}  // namespace fringetwin::calib
