// SPDX-License-Identifier: Apache-2.0
// Tells from a verdict's rows that the windows of a measured shape smooth away what the images show
// (docs/metrics/verdict.md, "Explained").
#pragma once
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "compare/shape/shape_noise.hpp"

namespace fringetwin::compare {

/// Returns whether what the regions of a row differ by goes with what smoothing has changed of the measured
/// shape, as other windows tell it, and is not much more: noise goes against it, and what else is wrong of a
/// rig hardly goes with it.
bool is_smoothed(const ExplainedRow& row);

/// Says so in the rows on gray values that are not explained. Where nothing else fails but coverage, smaller
/// windows should come before any search for causes, of which the best of wrong ones would be named: returns
/// that, with a warning. `noise`: of the shape; null: none.
bool doubt_smoothing(const ShapeNoise* noise, std::vector<ExplainedRow>& rows,
                     std::vector<std::string>& warnings);

}  // namespace fringetwin::compare
