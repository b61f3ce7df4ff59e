// SPDX-License-Identifier: Apache-2.0
// Finds where the joint solve starts: each device is solved alone, in stages from a rough focal length; then
// the rig follows from the views that devices share, with the check that they see the same corners in the
// same order.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "calib/board/observations.hpp"
#include "calib/solve/pnp.hpp"
#include "calib/solve/problem.hpp"

namespace fringetwin::calib {

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
