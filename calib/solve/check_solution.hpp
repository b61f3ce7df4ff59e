// SPDX-License-Identifier: Apache-2.0
// Checks what a solved calibration must satisfy to be believed, and throws what is wrong with it.
#pragma once
#include "calib/solve/calibration.hpp"

namespace fringetwin::calib {

/// Throws UserError(no_convergence) for a solution that is not one: not finite, a board behind a device, an
/// absurd lens; UserError(input) for a device or a view that fits badly. Fills calibration.warnings.
void check_solution(Calibration& calibration, const CalibrateOptions& options);

}  // namespace fringetwin::calib
