// SPDX-License-Identifier: Apache-2.0
// What is left follows, where no cause is named: a table, a plot per coordinate and a map per camera.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/page/field_table.hpp"
#include "compare/page/report_parts.hpp"
#include "report/map.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kPatternMapPx = 400;  ///< the longer side of a map
constexpr int kRowPx = 16;          ///< of a cell or an image, whose phases lie across
constexpr const char* kCameraColors[] = {report::color::kReal, report::color::kSimulated};

/// Returns the largest mean of all: one scale for all pictures, or noise would look like a pattern.
double largest_mean(const std::vector<PatternRow>& rows) {
  double largest = 1e-3;
  for (const PatternRow& row : rows)
    for (const PatternProfile& p : row.profile)
      for (const double mean : p.mean)
        if (std::isfinite(mean)) largest = std::max(largest, std::abs(mean));
  return largest;
}

report::Plot pattern_plot(const PatternRow& row, double scale) {
  report::Plot plot{
      .x_label = row.unit.empty() ? "image number" : fmt::format("{} [{}]", row.coordinate, row.unit),
      .y_label = "left [σ]",
      .zero_line = true,
      .width_px = 480,
      .height_px = 240,
      .y_range = {{-scale, scale}}};
  std::ranges::replace(plot.x_label, '_', ' ');
  for (const PatternProfile& p : row.profile)
    plot.series.push_back({.title = row.profile.size() > 1 ? p.camera : "",
                           .x = p.at,
                           .y = p.mean,
                           .color = kCameraColors[plot.series.size() % std::size(kCameraColors)]});
  return plot;
}

/// Draws the cells of a camera, which stand row by row: places, or phases across and places or images down.
std::string pattern_map(const PatternRow& row, const PatternProfile& p, double scale) {
  const auto across = static_cast<std::size_t>(std::ranges::count(p.at_y, p.at_y.front()));
  const std::size_t down = p.at.size() / across;
  int w = kPatternMapPx, h = kRowPx * static_cast<int>(down);
  if (row.coordinate == "place") {
    const double width = p.at[across - 1] - p.at[0], height = p.at_y.back() - p.at_y[0],
                 px = kPatternMapPx / std::max({width, height, 1.0});
    w = std::max(static_cast<int>(across), static_cast<int>(px * width));
    h = std::max(static_cast<int>(down), static_cast<int>(px * height));
  }
  ImageF map(w, h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      map(x, y) = static_cast<float>(
          p.mean[static_cast<std::size_t>(y) * down / static_cast<std::size_t>(h) * across +
                 static_cast<std::size_t>(x) * across / static_cast<std::size_t>(w)]);
  const report::MapStyle style{.scale = report::Scale::diverging,
                               .limits = {-scale, scale},
                               .unit = "σ",
                               .title = "mean of what is left",
                               .max_width_px = kPatternMapPx};
  const std::string axes =
      row.coordinate == "place"
          ? fmt::format("x {}…{} px, y {}…{} px", report::fixed(p.at[0], 0), report::fixed(p.at.back(), 0),
                        report::fixed(p.at_y[0], 0), report::fixed(p.at_y.back(), 0))
      : row.coordinate == "phase_by_place"
          ? fmt::format("phase 0…2π across, {} places of the image down, row by row",
                        report::fixed(p.at_y.back(), 0))
          : fmt::format("phase 0…2π across, {} images down, from {} to {}", down, report::fixed(p.at_y[0], 0),
                        report::fixed(p.at_y.back(), 0));
  return titled_map(fmt::format("{}: {}", report::escape_html(p.camera), axes), report::map_html(map, style));
}

}  // namespace

std::string pattern_html(const Comparison& c) {
  if (c.causes.pattern.empty()) return "";
  report::Table table = field_table(c.causes.pattern);
  table.caption =
      "What is left of the gray values follows: shares of the excess that means over each of these take "
      "away, "
      "each quarter of the image (by place: of the images; phase by image: each strip) predicted from the "
      "other three.";
  const double scale = largest_mean(c.causes.pattern);
  std::vector<report::Plot> plots;
  std::string parts, maps;
  for (const PatternRow& row : c.causes.pattern)
    if (std::ranges::all_of(row.profile, [](const PatternProfile& p) { return p.at_y.empty(); }))
      plots.push_back(pattern_plot(row, scale));
    else
      for (const PatternProfile& p : row.profile) maps += pattern_map(row, p, scale);
  for (const std::string& svg : report::plots_or_sentences(plots, "pattern"))
    parts += "<div class=\"map\">" + svg + "</div>";
  return table.html() + "<figure><div class=\"maps\">" + parts + maps +
         "</div><figcaption>Means of real − predicted in standard deviations of a gray value (σ): over the "
         "predicted level, the phase of the fringes (0 where they are brightest), the images, the distance "
         "from the middle of the camera's image, the place, and the phase at places and "
         "in images apart.</figcaption></figure>";
}

}  // namespace fringetwin::compare
