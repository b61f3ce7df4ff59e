// SPDX-License-Identifier: Apache-2.0
// Makes the numbers at the axes of a plot tell its values apart: a unit that fits them, and enough digits.
#pragma once
#include <string>
#include <utility>

#include "report/plot/plot_series.hpp"

namespace fringetwin::report {

/// Returns the plot with its small lengths in µm: an axis whose label ends in [mm], whose values all lie
/// within 10 µm of 0, and which has no names in the place of numbers and no logarithm.
Plot with_fitting_units(Plot plot);

/// Returns how many digits tell the numbers at an axis from `low` to `high` apart, 3 ... 15.
int digits_that_tell(double low, double high);

/// Returns the format in which gnuplot must print the numbers from `low` to `high` at an axis so that no two
/// neighbours look alike; empty where its own does. It has 5 decimals: 0.00003, 0.00003, 0.00003.
std::string tic_format(double low, double high);

/// Returns the smallest and the largest value along an axis, or the range that is given; NaN without any.
std::pair<double, double> x_extent(const Plot& plot);
std::pair<double, double> y_extent(const Plot& plot);

}  // namespace fringetwin::report
