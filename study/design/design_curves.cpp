// SPDX-License-Identifier: Apache-2.0
// Draws curves and scatter plots of a design.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/text.hpp"
#include "study/design/design_figures.hpp"
#include "study/page/report_parts.hpp"

namespace fringetwin::study {
namespace {

using report::Plot, report::Series;

constexpr std::size_t kMostMarks = 300;  // of a scatter plot: each takes 100 bytes of the page

const std::vector<const char*> kCurveColors = {report::color::kReal,
                                               report::color::kSimulated,
                                               report::color::kThird,
                                               report::color::kFourth,
                                               "#B8860B",
                                               "#56B4E9"};

/// A mean or sigma to be drawn, with its band.
struct Picked {
  double value = 0.0;
  Interval band;
};
using Pick = Picked (*)(const GroupStatistics&);
Picked pick_mean(const GroupStatistics& g) { return {g.mean, g.mean_band}; }
Picked pick_sigma(const GroupStatistics& g) { return {g.sigma, g.sigma_band}; }

std::string mean_label(const TableNumber& n) { return with_unit(n.is_error ? "mean error" : "mean", n.unit); }

/// Returns the values and ends of bands of all series of a plot.
std::vector<double> all_values(const Plot& plot) {
  std::vector<double> out;
  for (const Series& s : plot.series)
    for (const auto* values : {&s.y, &s.y_low, &s.y_high})
      out.insert(out.end(), values->begin(), values->end());
  return out;
}

/// Returns the mean of what is expected at a level, of sigmas the root mean square; NaN where one is not
/// known.
double expected_at(const DesignTable& table, const std::vector<double>& expected, bool squares,
                   std::size_t axis, std::size_t level, std::size_t other, std::size_t at) {
  double sum = 0.0;
  int n = 0;
  for (std::size_t s = 0; s < expected.size(); ++s) {
    const std::vector<std::size_t>& levels = table.settings[s].level;
    if (levels[axis] != level || (other != SIZE_MAX && levels[other] != at)) continue;
    sum += squares ? expected[s] * expected[s] : expected[s];
    ++n;
  }
  return n == 0 ? kNan : squares ? std::sqrt(sum / n) : sum / n;
}

/// Returns the levels that are drawn: all, or of too many every so many-th.
std::size_t level_step(const VariedAxis& axis) {
  return std::max(std::size_t{1}, (axis.values.size() + kMostLevels - 1) / kMostLevels);
}

struct Curve {
  std::string title, color;
  double shift = 0.0;  ///< of categories, beside the other curves
};

/// Adds what is expected of a curve, dashed in its colour; of single runs plus and minus the expected sigma.
void add_expected(const DesignTable& table, const TableNumber& number, std::size_t axis, bool sigma,
                  std::size_t other, std::size_t at, const Curve& curve, Plot* plot) {
  const auto line = [&](const std::vector<double>& expected, bool squares, double factor, const char* title) {
    if (expected.empty()) return;
    const bool numeric = table.axes[axis].numeric;
    Series s{.title = at == 0 ? title : "",
             .style = numeric ? Series::Style::dashed : Series::Style::points,
             .color = curve.color,
             .width = numeric ? 1.2 : 4.0,
             .point_type = 12};
    for (std::size_t i = 0; i < table.axes[axis].values.size(); i += level_step(table.axes[axis])) {
      s.add(table.axes[axis].values[i] + curve.shift,
            factor * expected_at(table, expected, squares, axis, i, other, at));
    }
    plot->series.push_back(s);
  };
  if (sigma) return line(number.expected_sigma, true, 1.0, "expected");
  line(number.expected_mean, false, 1.0, "expected");
  if (!number.all.band_of_settings || !number.is_error) return;
  line(number.expected_sigma, true, 1.0, "± expected sigma");
  line(number.expected_sigma, true, -1.0, "");
}

void add_curve(const VariedAxis& axis, const std::vector<GroupStatistics>& levels, Pick pick,
               const Curve& curve, Plot* plot) {
  Series line{.title = curve.title, .style = Series::Style::line, .color = curve.color, .width = 1.8};
  Series high = line;
  for (std::size_t i = 0; i < levels.size(); i += level_step(axis)) {
    const Picked p = pick(levels[i]);
    if (std::isnan(p.value)) continue;
    line.add(axis.values[i] + curve.shift, p.value);
    high.add(line.x.back(), std::isnan(p.band.high) ? p.value : p.band.high);
    high.y_low.push_back(std::isnan(p.band.low) ? p.value : p.band.low);
  }
  if (!axis.numeric) {
    Series whiskers = high;
    whiskers.style = Series::Style::whiskers;
    whiskers.width = 2.4;
    std::swap(whiskers.y, whiskers.y_high);
    whiskers.y = line.y;
    plot->series.push_back(whiskers);
    return;
  }
  high.style = Series::Style::band;
  high.title = "";
  plot->series.push_back(high);
  Series points = line;
  points.style = Series::Style::points;
  points.title = "";
  points.width = 1.6;
  plot->series.push_back(line);
  if (levels.size() <= 30) plot->series.push_back(points);
}

/// Returns the other axis, among those with few values, that changes the number most.
std::size_t second_axis(const DesignTable& table, const TableNumber& number, std::size_t axis) {
  std::size_t best = SIZE_MAX;
  double most = -1.0;
  for (std::size_t k = 0; k < table.axes.size(); ++k) {
    const std::size_t n = table.axes[k].values.size();
    if (k == axis || n < 2 || n > kMostCurves) continue;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const GroupStatistics& g : by_level(table, number, k))
      if (std::isfinite(g.mean)) low = std::min(low, g.mean), high = std::max(high, g.mean);
    if (high - low > most) most = high - low, best = k;
  }
  return best;
}

Plot level_plot(const DesignTable& table, const TableNumber& number, std::size_t axis, Pick pick) {
  const VariedAxis& a = table.axes[axis];
  Plot plot = axis_plot(table.axes[axis]);
  const std::size_t other = table.scattered ? SIZE_MAX : second_axis(table, number, axis);
  if (other == SIZE_MAX) {
    add_curve(a, by_level(table, number, axis), pick, {"", report::color::kReal}, &plot);
    add_expected(table, number, axis, pick == pick_sigma, SIZE_MAX, 0, {"", report::color::kDifference},
                 &plot);
    return plot;
  }
  const VariedAxis& b = table.axes[other];
  plot.title = ", by " + b.brief;
  const std::size_t n = b.values.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Curve curve{shortened(b.names[k]), kCurveColors[k],
                      a.numeric ? 0.0 : 0.12 * (static_cast<double>(k) - 0.5 * static_cast<double>(n - 1))};
    add_curve(a, by_level(table, number, axis, other, k), pick, curve, &plot);
    add_expected(table, number, axis, pick == pick_sigma, other, k, curve, &plot);
  }
  return plot;
}

/// Returns a plot with one point per setting and the running mean.
Plot scatter_plot(const DesignTable& table, const TableNumber& number, std::size_t axis, Pick pick) {
  const VariedAxis& a = table.axes[axis];
  Plot plot = axis_plot(table.axes[axis]);
  std::vector<double> x, y;
  for (std::size_t s = 0; s < table.settings.size(); ++s) {
    x.push_back(a.values[table.settings[s].level[axis]]);
    y.push_back(pick(group_statistics({&number.runs[s]}, kReportCoverage)).value);
  }
  std::vector<double> place = x;
  if (a.log)
    for (double& v : place) v = std::log(v);
  RunningMean mean = running_mean(place, y, kReportCoverage);
  if (a.log)
    for (double& v : mean.x) v = std::exp(v);

  Series points{.title = "settings",
                .style = Series::Style::points,
                .color = "#7fb2d0",
                .width = x.size() > 200 ? 0.9 : 1.5};
  const std::size_t step = (x.size() + kMostMarks - 1) / kMostMarks;
  for (std::size_t i = 0; i < x.size(); i += step) points.add(x[i], y[i]);
  plot.series = {points};
  if (mean.x.empty()) return plot;
  plot.series.push_back({.title = "",
                         .x = mean.x,
                         .y = mean.high,
                         .y_low = mean.low,
                         .style = Series::Style::band,
                         .color = report::color::kSimulated});
  plot.series.push_back({.title = "running mean",
                         .x = mean.x,
                         .y = mean.mean,
                         .style = Series::Style::line,
                         .color = report::color::kSimulated,
                         .width = 2.0});
  return plot;
}

/// `drawn`: axes that are told apart in the plot.
std::string band_words(const DesignTable& table, const TableNumber& number, bool scatter_points,
                       std::size_t drawn) {
  if (scatter_points)
    return std::string(
               "One point per setting (mean over its seeds), running mean over equally many settings with "
               "the 95 % interval of that mean by Student's t over them: the other parameters vary, too.") +
           (table.settings.size() > kMostMarks
                ? fmt::format(" At most {} of the {} settings are drawn as points, the mean is over all.",
                              kMostMarks, table.settings.size())
                : "");
  const GroupStatistics& g = number.all;
  const bool averaged = table.axes.size() > drawn;
  std::string out = averaged ? "Averaged over the parameters that are not named. " : "";
  if (g.band_of_settings)
    return out + (averaged ? "Band: 95 % of the mean by Student's t over the settings averaged (one noise "
                             "seed: the spread is that of the other parameters)."
                           : "One run each: no band.");
  return out + fmt::format(
                   "Bands, 95 %: of the mean by Student's t over {} noise seeds; of sigma, the scatter over "
                   "the seeds, by chi-square with {} degrees of freedom.",
                   g.seeds, g.seeds - 1);
}

}  // namespace

std::string axis_figures(const DesignTable& table, const TableNumber& number, FigureSheet* sheet) {
  std::string out;
  for (std::size_t axis = 0; axis < std::min(table.axes.size(), kMostAxes); ++axis) {
    const bool points = table.scattered && table.axes[axis].numeric;
    const auto plot_of = [&](Pick pick) {
      return points ? scatter_plot(table, number, axis, pick) : level_plot(table, number, axis, pick);
    };
    Plot mean = plot_of(pick_mean);
    mean.title = "mean of " + shortened(number.name, 40) + mean.title;
    mean.y_label = mean_label(number);
    mean.zero_line = number.is_error;
    mean.log_y = !number.is_error && spans_a_decade(all_values(mean));
    mean.many_digits = needs_many_digits(all_values(mean));
    const std::string name = number.name + "-" + table.axes[axis].brief;
    const std::size_t step = points ? 1 : level_step(table.axes[axis]),
                      levels = table.axes[axis].values.size();
    const std::string thinned =
        step > 1 ? fmt::format(" Of {} levels {} are drawn.", levels, (levels + step - 1) / step) : "";
    std::vector<std::string> row = {sheet->place(name + "-mean", mean)};
    if (number.has_scatter()) {
      Plot sigma = plot_of(pick_sigma);
      sigma.title = "sigma of " + shortened(number.name, 40) + sigma.title;
      sigma.y_label = with_unit("sigma over seeds", number.unit);
      sigma.log_y = spans_a_decade(all_values(sigma));
      row.push_back(sheet->place(name + "-sigma", sigma));
    }
    out += report::figure_html(
        FigureSheet::row(row),
        band_words(table, number, points, mean.title.find(", by ") == std::string::npos ? 1 : 2) + thinned);
  }
  return out;
}

}  // namespace fringetwin::study
