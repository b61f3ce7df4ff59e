// SPDX-License-Identifier: Apache-2.0
// Draws a value per pair of levels as coloured cells with the numbers in them, drawn by gnuplot.
#pragma once
#include <string>
#include <vector>

#include "report/map.hpp"
#include "report/plot/plot.hpp"

namespace fringetwin::report {

struct HeatMap {
  std::string title, x_label, y_label;        ///< title: with the unit of the values
  std::vector<std::string> x_names, y_names;  ///< of the levels; y from the bottom to the top
  std::vector<std::vector<double>> values;    ///< [y][x]; NaN: an empty cell
  Scale scale = Scale::viridis;
  MapLimits limits;
  bool log_color = false;  ///< limits > 0
  int width_px = 540, height_px = 340;
};

/// Numbers stand in the cells where these are wide enough.
Drawing drawing(const HeatMap& map);

/// Returns the limits of the finite values: around 0 for the diverging scale, else from the least to the
/// greatest.
MapLimits limits_of(const std::vector<std::vector<double>>& values, Scale scale);

}  // namespace fringetwin::report
