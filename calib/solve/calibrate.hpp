// SPDX-License-Identifier: Apache-2.0
// One joint solve for all devices, all board poses and the board's warp: observed corners go in, a checked
// calibration comes out.
#pragma once
#include "calib/solve/calibration.hpp"

namespace fringetwin::calib {

/// Checks the input, seeds, solves, checks the solution. Throws UserError: input for observations that cannot
/// be right, no_convergence for a solution that cannot be.
Calibration calibrate(const Observations& observations, const CalibrateOptions& options);

}  // namespace fringetwin::calib
