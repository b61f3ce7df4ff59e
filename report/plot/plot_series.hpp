// SPDX-License-Identifier: Apache-2.0
// Holds what a plot shows: series of numbers, axes and colours.
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

}  // namespace fringetwin::report
