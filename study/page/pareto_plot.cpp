// SPDX-License-Identifier: Apache-2.0
#include "study/page/pareto_plot.hpp"

#include <algorithm>

#include "study/page/report_parts.hpp"

namespace fringetwin::study {
namespace {

using report::Series;

/// Returns a little more than the range from the least to the greatest.
std::optional<std::pair<double, double>> range_of(const std::vector<double>& values, bool log) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const double v : values)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  if (!(low < high)) return std::nullopt;
  if (log) return std::pair{low * std::pow(low / high, 0.05), high * std::pow(high / low, 0.1)};
  return std::pair{low - 0.05 * (high - low), high + 0.1 * (high - low)};
}

}  // namespace

std::string front_mark(std::size_t i) {
  return i < 26 ? std::string(1, static_cast<char>('A' + i)) : std::to_string(i + 1);
}

report::Plot front_plot(const std::vector<CostAndError>& points, const std::vector<std::size_t>& front,
                        const std::string& title) {
  report::Plot plot{.x_label = "acquisition time [s]", .width_px = 980, .height_px = 400};
  Series all{.title = title, .style = Series::Style::points, .color = "#7fb2d0", .width = 2.0};
  for (const CostAndError& p : points) all.add(p.cost, p.error);
  plot.log_x = spans_a_decade(all.x);
  plot.log_y = spans_a_decade(all.y);
  plot.x_range = range_of(all.x, plot.log_x);
  Series steps{.title = "Pareto front", .style = Series::Style::dashed, .color = report::color::kDifference};
  Series marked{
      .title = "", .style = Series::Style::points, .color = report::color::kSimulated, .width = 3.2};
  for (std::size_t i = 0; i < front.size(); ++i) {
    const CostAndError& p = points[front[i]];
    if (i > 0) steps.add(p.cost, points[front[i - 1]].error);
    steps.add(p.cost, p.error);
    marked.add(p.cost, p.error);
    marked.labels.push_back(front_mark(i));
  }
  plot.series = {all, steps, marked};
  return plot;
}

}  // namespace fringetwin::study
