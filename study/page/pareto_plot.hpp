// SPDX-License-Identifier: Apache-2.0
// Acquisition time against uncertainty, as a drawing; internal to study/.
#pragma once
#include <string>
#include <vector>

#include "report/plot.hpp"
#include "twin/base/pareto_front.hpp"

namespace fringetwin::study {

/// "A", "B" ... of the points of a front, by rising time.
std::string front_mark(std::size_t i);

/// Points as `title`, the front marked with its letters, steps between; without a label of y.
report::Plot front_plot(const std::vector<CostAndError>& points, const std::vector<std::size_t>& front,
                        const std::string& title);

}  // namespace fringetwin::study
