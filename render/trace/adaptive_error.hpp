// SPDX-License-Identifier: Apache-2.0
// Estimates the errors of the adaptive trace's rules, and finds which of them a budget allows.
#pragma once
#include <array>
#include <vector>

namespace fringetwin::render {

/// Lobatto's rule for a panel of four scan lines (nodes -1, -sqrt(1/5), sqrt(1/5), 1).
constexpr std::array<double, 4> kPanelWeights{1.0 / 12, 5.0 / 12, 5.0 / 12, 1.0 / 12};
/// Returns the estimated error of that rule, given the same four line integrals: their second difference
/// tells curvature and kinks, their odd difference jumps. A kink of slope k in the middle of a gap between
/// lines leaves k/40 of the squared panel width, the estimate says k/25 ... k/10. A jump may be
/// underestimated four times, but is then far above any target, so that its panel is halved.
double panel_error(const std::array<double, 4>& lines);

/// The error of the higher of two Gauss orders, as a share of the difference of both: 1/20 or less for smooth
/// integrands; towards a silhouette, where the phase runs with the root of the distance, up to a quarter.
constexpr double kOrderSafety = 0.25;

/// Returns the largest error to keep so that the squares of all kept ones add up to `budget` at most, and
/// none is above `cap`; a negative number when none may be kept.
double largest_error_to_keep(std::vector<double> errors, double budget, double cap);

}  // namespace fringetwin::render
