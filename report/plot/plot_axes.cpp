// SPDX-License-Identifier: Apache-2.0
#include "report/plot/plot_axes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

namespace fringetwin::report {
namespace {

using Values = std::vector<double> Series::*;
using Range = std::pair<double, double>;

constexpr std::initializer_list<Values> kAlongX = {&Series::x, &Series::x_low, &Series::x_high};
constexpr std::initializer_list<Values> kAlongY = {&Series::y, &Series::y_low, &Series::y_high};

constexpr const char* kMillimetres = "[mm]";
constexpr double kSmall_mm = 0.01;
constexpr double kFinestOfGnuplot = 1e-5;  ///< step that it tells apart
constexpr double kMostTics = 20.0;

Range extent(const Plot& plot, std::initializer_list<Values> along, const std::optional<Range>& given) {
  if (given) return *given;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Series& series : plot.series)
    for (const Values values : along)
      for (const double v : series.*values)
        if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  if (low > high) return {std::nan(""), std::nan("")};
  return {low, high};
}

/// Multiplies the values along an axis and changes its label.
void put_in_micrometres(Plot& plot, std::initializer_list<Values> along, std::string& label,
                        std::optional<Range>& given) {
  constexpr double kPerMm = 1000.0;
  for (Series& series : plot.series)
    for (const Values values : along)
      for (double& v : series.*values) v *= kPerMm;
  if (given) given = {kPerMm * given->first, kPerMm * given->second};
  label.replace(label.size() - std::string(kMillimetres).size(), std::string::npos, "[µm]");
}

bool is_small(const Range& extent) {
  return std::max(std::abs(extent.first), std::abs(extent.second)) < kSmall_mm;
}

}  // namespace

std::pair<double, double> x_extent(const Plot& plot) { return extent(plot, kAlongX, plot.x_range); }
std::pair<double, double> y_extent(const Plot& plot) { return extent(plot, kAlongY, plot.y_range); }

Plot with_fitting_units(Plot plot) {
  if (plot.x_label.ends_with(kMillimetres) && plot.x_tics.empty() && !plot.log_x && is_small(x_extent(plot)))
    put_in_micrometres(plot, kAlongX, plot.x_label, plot.x_range);
  if (plot.y_label.ends_with(kMillimetres) && plot.y_tics.empty() && !plot.log_y && is_small(y_extent(plot)))
    put_in_micrometres(plot, kAlongY, plot.y_label, plot.y_range);
  return plot;
}

int digits_that_tell(double low, double high) {
  const double step = (high - low) / kMostTics;
  const double digits = std::ceil(std::log10(std::max(std::abs(low), std::abs(high)) / step)) + 1.0;
  return std::isfinite(digits) ? static_cast<int>(std::clamp(digits, 3.0, 15.0)) : 3;
}

std::string tic_format(double low, double high) {
  const double step = (high - low) / kMostTics;
  if (!(step > 0.0) || !std::isfinite(step) || step >= kFinestOfGnuplot) return "";
  return fmt::format("%.{}g", digits_that_tell(low, high));
}

}  // namespace fringetwin::report
