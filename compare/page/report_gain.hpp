// SPDX-License-Identifier: Apache-2.0
// Shows the gain: real gray values over simulated irradiance with the fitted line, and what parts of the gray
// values say of it.
#pragma once
#include <string>
#include <vector>

#include "compare/gray/gain_fit.hpp"
#include "report/plot/plot.hpp"

namespace fringetwin::compare {

/// Draws median and 5 ... 95 % band of the real gray values in bins of E with the fitted line, and below it
/// the same of simulated - real. Empty when there is nothing to draw.
std::vector<report::Plot> gain_plots(const GrayPair& pair, const GainFit& fit);

/// Returns what gain and black level of each camera are worth, with the table of its parts as HTML; empty
/// where nothing was checked.
std::string gain_checks_html(const Comparison& comparison);

}  // namespace fringetwin::compare
