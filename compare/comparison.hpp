// SPDX-License-Identifier: Apache-2.0
// Compares a real with a simulated side: gray values, gain, phase, fitted geometry, the budget that should
// explain their differences, and the verdict on the limits of the twin.
#pragma once
#include <vector>

#include "compare/result/options.hpp"
#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// With twin.calibration_uncertainty and a renderer the calibration's covariance is part of the budgets; that
/// takes a rendering and a measurement per parameter.
/// All differences are simulated - real. Pixels whose predicted value is near a clip, saturated
/// pixels and images of another exposure are left out of gain and gray. A side without images leaves
/// gain, gray and phase empty. Throws UserError(usage) for an unknown name in twin.limits and
/// UserError(input) where the two sides do not belong together (sizes, number of images).
Comparison compare(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options);

/// Returns the rows of the verdict on the phase alone; none where a side has no images.
std::vector<ExplainedRow> explain_phases(const Twin& twin, const Side& real, const Side& simulated,
                                         const CompareOptions& options);

}  // namespace fringetwin::compare
