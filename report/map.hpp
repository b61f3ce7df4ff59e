// SPDX-License-Identifier: Apache-2.0
// Draws a float image as a coloured map with colour bar, unit and limits.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "report/color_scale.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::report {

struct MapLimits {
  double low = 0.0, high = 1.0;
};

/// Percentiles of the finite values (defaults: the middle 98 %); widened when they coincide.
/// [0, 1] when nothing is finite.
MapLimits robust_limits(const ImageF& image, double low_percent = 1.0, double high_percent = 99.0);
/// [-a, a] with a the percentile of |value|, for the diverging scale.
MapLimits symmetric_limits(const ImageF& image, double percent = 99.0);
/// Percentile by linear interpolation between order statistics; NaN values are left out; NaN when empty.
double percentile(std::vector<float> values, double percent);

/// The smallest whole factor that makes the image at most `max_width_px` wide; each output pixel is
/// the mean of the finite values in its block, NaN where fewer than half of them are finite.
ImageF shrink_by_area_mean(const ImageF& image, int max_width_px);

struct MapStyle {
  Scale scale = Scale::viridis;
  MapLimits limits = {};
  std::string unit = {};   ///< "rad", "DN", "mm"
  std::string title = {};  ///< short, also the alternative text
  int max_width_px = 640;  ///< on the page
  Rgb nan_color = kNanColor;
  bool show_bar = true;
};

/// Palette indices (see map_palette) of an image.
ImageU8 map_indices(const ImageF& image, const MapLimits& limits);
/// <div class="bar">: colour bar, unit and limits.
std::string color_bar_html(const MapStyle& style);
/// PNG bytes, one pixel per image pixel, no bar; unit and limits as text chunks.
std::string map_png(const ImageF& image, const MapStyle& style);
/// <div class="map">: the shrunk picture as a data URI, its colour bar, unit and limits.
std::string map_html(const ImageF& image, const MapStyle& style);
/// Full resolution with a labelled colour bar below. Written to a temporary name, then renamed.
void write_map_png(const std::filesystem::path& file, const ImageF& image, const MapStyle& style);

/// Two gray images of one size, one over the other with a slider between them (side by side in
/// print). `id` is unique on the page.
std::string slider_html(const ImageF& left, const std::string& left_label, const ImageF& right,
                        const std::string& right_label, const MapStyle& style, const std::string& id);

}  // namespace fringetwin::report
