// SPDX-License-Identifier: Apache-2.0
// Plots as inline SVG, drawn by gnuplot (fed through a pipe, no temporary files).
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::report {

/// Colour-blind-safe line colours (Okabe and Ito).
namespace color {
inline constexpr const char* kReal = "#0072B2";
inline constexpr const char* kSimulated = "#D55E00";
inline constexpr const char* kDifference = "#333333";
inline constexpr const char* kThird = "#009E73";
inline constexpr const char* kFourth = "#CC79A7";
}  // namespace color

struct Series {
  enum class Style { line, dashed, points, bars, band };
  std::string title;                ///< legend; empty = none
  std::vector<double> x, y, y_low;  ///< NaN breaks a line; y_low only for band
  Style style = Style::line;
  std::string color = color::kReal;
  double width = 1.4;
  int point_type = 7;  ///< gnuplot's symbols: 4/5 square, 6/7 circle, 8/9 triangle, 12/13 diamond
  std::vector<std::string> labels = {};  ///< beside the points; empty, or one per value (points only)
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<Series> series;
  bool log_x = false, log_y = false;
  bool zero_line = false;
  int width_px = 980, height_px = 300;
  std::optional<std::pair<double, double>> x_range, y_range;
  std::vector<std::pair<double, std::string>> x_tics;  ///< named positions instead of numbers
};

/// The commands and data gnuplot is given.
std::string gnuplot_script(const Plot& plot);

/// Inline <svg>. All ids are made unique per page by `id`. Throws UserError(usage) when gnuplot is
/// missing (says which package brings it) or refuses the plot.
std::string plot_svg(const Plot& plot, const std::string& id);

/// As above for several plots at once (gnuplot started once per plot, at the same time); a plot that
/// cannot be drawn becomes a sentence that says so, so that the rest of the report is still written.
std::vector<std::string> plots_or_sentences(const std::vector<Plot>& plots, const std::string& id_prefix);

struct Histogram {
  double low = 0.0, bin_width = 0.0;
  std::vector<std::size_t> counts;  ///< values outside [low, high] are not counted
  std::size_t n_below = 0, n_above = 0;
};
/// Throws on bins < 1 or low >= high (programming fault). Non-finite values are ignored.
Histogram histogram(const std::vector<float>& values, int bins, double low, double high);
/// The histogram as a series of bars, in percent of all finite values.
Series histogram_series(const Histogram& h, const std::string& title, const std::string& color);

}  // namespace fringetwin::report
