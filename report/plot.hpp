// SPDX-License-Identifier: Apache-2.0
// Draws plots as inline SVG: series of numbers go in, gnuplot draws them (fed through a pipe, no temporary
// files), <svg> elements come out. It also makes histograms as series.
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
  /// Whiskers: points with bars from y_low to y_high; the *_across lie along x: bars from 0 to x at the place
  /// y, and bars from x_low to x_high.
  enum class Style { line, dashed, points, bars, band, whiskers, bars_across, whiskers_across };
  std::string title = {};                          ///< legend; empty = none
  std::vector<double> x = {}, y = {}, y_low = {};  ///< NaN breaks a line; y_low only for band
  Style style = Style::line;
  std::string color = color::kReal;
  double width = 1.4;
  int point_type = 7;  ///< gnuplot's symbols: 4/5 square, 6/7 circle, 8/9 triangle, 12/13 diamond
  std::vector<std::string> labels = {};  ///< beside the points; empty, or one per value (points only)
  std::vector<double> y_high = {}, x_low = {}, x_high = {};  ///< of whiskers

  /// Adds a point.
  void add(double at, double value) {
    x.push_back(at);
    y.push_back(value);
  }
};

struct Plot {
  std::string title = {}, x_label = {}, y_label = {};
  std::vector<Series> series = {};
  bool log_x = false, log_y = false;
  bool zero_line = false;  ///< at y = 0; with y_tics at x = 0
  int width_px = 980, height_px = 300;
  std::optional<std::pair<double, double>> x_range = {}, y_range = {};
  std::vector<std::pair<double, std::string>> x_tics = {};  ///< named positions instead of numbers
  std::vector<std::pair<double, std::string>> y_tics = {};
  bool many_digits = false;  ///< tics print all digits that tell them apart: small changes of large values
};

/// Holds the script that makes gnuplot draw one plot.
struct Drawing {
  std::string title;   ///< for messages
  std::string script;  ///< empty where there are no data
};

/// Returns any text as a gnuplot string in double quotes, escaped.
std::string gnuplot_text(const std::string& text);
/// Returns the gnuplot commands that all drawings begin with: terminal, fonts, borders and grid.
std::string gnuplot_head(int width_px, int height_px);
/// Returns the commands and data that make gnuplot draw the plot.
std::string gnuplot_script(const Plot& plot);
/// Returns the plot as a drawing, whose script is empty when no series has data.
Drawing drawing(const Plot& plot);

/// Returns an inline <svg>, all ids of which begin with `id` so that they are unique in a page. Throws
/// UserError(usage) when gnuplot is missing (says which package brings it) or refuses the plot.
std::string drawing_svg(const Drawing& drawing, const std::string& id);
std::string plot_svg(const Plot& plot, const std::string& id);

/// Does the same for several plots at once (gnuplot started once per plot, on all cores); a plot that
/// cannot be drawn becomes a sentence that says so, so that the rest of the report is still written. Throws
/// Cancelled.
std::vector<std::string> drawings_or_sentences(const std::vector<Drawing>& drawings,
                                               const std::string& id_prefix);
std::vector<std::string> plots_or_sentences(const std::vector<Plot>& plots, const std::string& id_prefix);

/// Returns an inline <svg> as the text of an SVG file of its own, on white.
std::string standalone_svg(const std::string& inline_svg);

struct Histogram {
  double low = 0.0, bin_width = 0.0;
  std::vector<std::size_t> counts;  ///< values outside [low, high] are not counted
  std::size_t n_below = 0, n_above = 0;
};
/// Counts the values in `bins` equal bins over [low, high]; non-finite values are ignored. Throws on bins < 1
/// or low >= high (programming fault).
Histogram histogram(const std::vector<float>& values, int bins, double low, double high);
/// Returns the histogram as a series of bars, in percent of all finite values.
Series histogram_series(const Histogram& h, const std::string& title, const std::string& color);

}  // namespace fringetwin::report
