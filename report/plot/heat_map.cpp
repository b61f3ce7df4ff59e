// SPDX-License-Identifier: Apache-2.0
#include "report/plot/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/plot/plot_axes.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::report {
namespace {

constexpr double kLetter_px = 7.2, kMarginUnit_px = 8.4;  // gnuplot's unit of margins
constexpr int kRightMargin = 10;                          // colour bar and its tics
constexpr int kCellLetters_px = 11;                       // of the numbers in its cells

std::string hex(Rgb c) { return fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b); }

/// The place of a value on the colour scale.
double place(const HeatMap& map, double value) {
  const auto [low, high] = map.limits;
  if (map.log_color) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

/// Relative luminance, roughly: dark cells get white letters.
bool is_dark(Rgb c) { return 0.299 * c.r + 0.587 * c.g + 0.114 * c.b < 140.0; }

std::string palette(Scale scale) {
  std::string out = "set palette defined (";
  constexpr int kStops = 32;
  for (int i = 0; i <= kStops; ++i)
    out += fmt::format("{}{} \"{}\"", i > 0 ? ", " : "", i,
                       hex(scale_color(scale, static_cast<double>(i) / kStops)));
  return out + ")\nset palette maxcolors 64\n";
}

std::string names(const std::vector<std::string>& all, std::size_t most) {
  std::string out;
  const std::size_t step = (all.size() + most - 1) / std::max(most, std::size_t{1});
  for (std::size_t i = 0; i < all.size(); i += step)
    out += fmt::format("{}{} {}", out.empty() ? "" : ", ", gnuplot_text(all[i]), i);
  return out;
}

/// Letters of the longest (UTF-8).
std::size_t longest(const std::vector<std::string>& all) {
  std::size_t most = 0;
  for (const std::string& name : all) {
    std::size_t n = 0;
    for (const char c : name) n += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
    most = std::max(most, n);
  }
  return most;
}

int left_margin(const HeatMap& map) {
  return static_cast<int>((7.0 * static_cast<double>(longest(map.y_names)) + 45.0) / kMarginUnit_px);
}

/// Width of the cells together.
double room_px(const HeatMap& map) {
  return map.width_px - kMarginUnit_px * (left_margin(map) + kRightMargin);
}

std::vector<std::vector<std::string>> cell_texts(const HeatMap& map, int digits) {
  std::vector<std::vector<std::string>> out(map.values.size());
  for (std::size_t y = 0; y < map.values.size(); ++y)
    for (const double v : map.values[y]) out[y].push_back(number(v, digits));
  return out;
}

/// Data blocks of the cells, of the light and of the dark numbers.
struct Blocks {
  std::string cells, light, dark;
};
Blocks blocks(const HeatMap& map) {
  const double cell_px = room_px(map) / static_cast<double>(map.x_names.size());
  const double cell_height_px =
      static_cast<double>(map.height_px - 90) / static_cast<double>(map.y_names.size());
  std::vector<std::vector<std::string>> text;
  bool written = false;
  for (int digits = 3; digits >= 2 && !written; --digits) {
    text = cell_texts(map, digits);
    std::size_t widest = 1;
    for (const auto& row : text) widest = std::max(widest, longest(row));
    written = cell_px > kLetter_px * static_cast<double>(widest) + 4.0 && cell_height_px > 14.0;
  }
  Blocks out;
  for (std::size_t y = 0; y < map.values.size(); ++y) {
    FT_CHECK(map.values[y].size() == map.x_names.size(), "a heat map has a value per pair of levels");
    for (std::size_t x = 0; x < map.values[y].size(); ++x) {
      const double v = map.values[y][x];
      if (!std::isfinite(v) || (map.log_color && v <= 0.0)) continue;
      out.cells += fmt::format("{0} {1} {2} {3} {4} {5} {6:.10g}\n", x, y, static_cast<double>(x) - 0.5,
                               static_cast<double>(x) + 0.5, static_cast<double>(y) - 0.5,
                               static_cast<double>(y) + 0.5, v);
      if (written)
        (is_dark(scale_color(map.scale, place(map, v))) ? out.light : out.dark) +=
            fmt::format("{} {} {}\n", x, y, gnuplot_text(text[y][x]));
    }
  }
  return out;
}

}  // namespace

MapLimits limits_of(const std::vector<std::vector<double>>& values, Scale scale) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& row : values)
    for (const double v : row)
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  if (low > high) return {0.0, 1.0};
  if (scale == Scale::diverging) {
    const double a = std::max(std::abs(low), std::abs(high));
    return a > 0.0 ? MapLimits{-a, a} : MapLimits{-1.0, 1.0};
  }
  if (low < high) return {low, high};
  const double step = low == 0.0 ? 1.0 : 0.5 * std::abs(low);  // all the same
  return {low - step, high + step};
}

Drawing drawing(const HeatMap& map) {
  FT_CHECK(map.values.size() == map.y_names.size(), "a heat map has a row per level");
  const Blocks data = blocks(map);
  if (data.cells.empty()) return {map.title, ""};
  std::string s = gnuplot_head(map.width_px, map.height_px);
  s += fmt::format("unset grid\nunset key\nset lmargin {}\nset rmargin {}\n", left_margin(map), kRightMargin);
  if (!map.title.empty()) s += "set title " + gnuplot_text(map.title) + "\n";
  s += "set xlabel " + gnuplot_text(map.x_label) + "\nset ylabel " + gnuplot_text(map.y_label) + "\n";
  s += palette(map.scale);
  s += fmt::format("set cbrange [{:.10g}:{:.10g}]\n", map.limits.low, map.limits.high);
  s += fmt::format("set format cb \"%.{}g\"\n",
                   std::max(6, digits_that_tell(map.limits.low, map.limits.high)));
  if (map.log_color) s += "set logscale cb\n";
  const std::size_t nx = map.x_names.size(), ny = map.y_names.size();
  s += fmt::format("set xrange [-0.5:{}.5]\nset yrange [-0.5:{}.5]\n", nx - 1, ny - 1);
  const bool aslant =
      static_cast<double>((longest(map.x_names) + 2) * std::min(nx, std::size_t{12})) * kLetter_px >
      room_px(map);
  s += fmt::format("set xtics ({}){}\nset ytics ({})\n", names(map.x_names, 12),
                   aslant ? " rotate by 25 right" : "", names(map.y_names, 16));
  s += "set object rectangle from graph 0,0 to graph 1,1 behind fc rgb \"#eeeeee\" fs solid noborder\n";
  s += "$cells << EOD\n" + data.cells + "EOD\n";
  std::string commands =
      "plot $cells using 1:2:3:4:5:6:7 with boxxyerror fs solid 1 border lc rgb \"#ffffff\" lc palette";
  const auto letters = [&](const char* block, const std::string& rows, const char* color) {
    if (rows.empty()) return;
    s += fmt::format("${} << EOD\n{}EOD\n", block, rows);
    commands += fmt::format(", ${} with labels tc rgb \"{}\" font \",{}\"", block, color, kCellLetters_px);
  };
  letters("light", data.light, "#ffffff");
  letters("dark", data.dark, "#1d2329");
  return {map.title, s + commands + "\n", least_width_px(map.width_px, kCellLetters_px)};
}

}  // namespace fringetwin::report
