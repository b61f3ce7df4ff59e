// SPDX-License-Identifier: Apache-2.0
// Computes form, size, flatness and spacing of the fitted objects, in the manner of VDI/VDE 2634 part 2
// (docs/metrics/geometry.md, "Indicators").
#pragma once
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// How far deviations from a fitted surface spread.
struct Ranges {
  double all_mm = kNaN;  ///< largest less smallest
  double p95_mm = kNaN;  ///< shortest interval that holds 95 % of the values
};
/// Returns the ranges of these deviations; unknown without values.
Ranges deviation_ranges(const std::vector<float>& deviation_mm);

/// Returns the names of the indicators that one fit of this kind of shape has ("sphere", "plane", ...).
std::vector<std::string> indicator_names(const std::string& kind);

/// Returns the indicators of the fits of both sides, in their order, spacings last. What neither side has is
/// left out; nominal sizes and places are those of the twin's objects.
std::vector<Indicator> indicators(const Twin& twin, const std::vector<FitRow>& fits);

}  // namespace fringetwin::compare
