// SPDX-License-Identifier: Apache-2.0
// Draws acquisition time against uncertainty, with the Pareto front; internal to study/.
#pragma once
#include <string>
#include <vector>

#include "report/plot/plot.hpp"
#include "twin/number/pareto_front.hpp"

namespace fringetwin::study {

/// Returns the letter "A", "B" ... of the i-th point of a front, by rising time.
std::string front_mark(std::size_t i);

/// Returns a plot of the points under `title`, with the front marked by its letters and steps between;
/// without a label of y.
report::Plot front_plot(const std::vector<CostAndError>& points, const std::vector<std::size_t>& front,
                        const std::string& title);

}  // namespace fringetwin::study
