// SPDX-License-Identifier: Apache-2.0
// Calibrates a rig: the corners that its devices saw of a board go in, and a checked calibration comes out.
// One bundle adjustment (by mrcal) solves for all devices, all board poses and the board's warp together.
#pragma once
#include "calib/solve/calibration.hpp"

namespace fringetwin::calib {

/// Checks the input, finds starting values, solves, and checks the solution. Throws UserError: input for
/// observations that cannot be right, no_convergence for a solution that cannot be.
Calibration calibrate(const Observations& observations, const CalibrateOptions& options);

/// Throws UserError(no_convergence) for a solution that is not one: not finite, a board behind a device, an
/// absurd lens; UserError(input) for a device or a view that fits badly. Fills calibration.warnings.
void check_solution(Calibration& calibration, const CalibrateOptions& options);

}  // namespace fringetwin::calib
