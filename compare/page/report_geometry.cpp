// SPDX-License-Identifier: Apache-2.0
// Deviation of the measured points from their fitted surface: map, histogram, point cloud.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "compare/geometry/deviation_cloud.hpp"
#include "compare/page/report_parts.hpp"
#include "report/cloud_canvas.hpp"
#include "report/html_page.hpp"
#include "report/map.hpp"
#include "report/plot/plot.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

using measure::Measurement;
using measure::ObjectFit;
using report::MapStyle;
using report::Plot;
using report::Scale;

/// One side of one fitted object that has deviations.
struct Deviations {
  const Measurement* measurement;
  const ObjectFit* fit;
  const char* side;
  const char* color;
};

std::vector<float> in_um(const ObjectFit& fit) {
  std::vector<float> um(fit.deviation_mm.size());
  for (std::size_t i = 0; i < um.size(); ++i) um[i] = 1000.0f * fit.deviation_mm[i];
  return um;
}

/// Returns the deviation at each point's source pixel of the first camera.
ImageF deviation_image(const Deviations& d, int width, int height) {
  ImageF image(width, height, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < d.fit->index.size(); ++i) {
    const Eigen::Vector2f q = d.measurement->cloud.q_cam_px[d.fit->index[i]];
    const long x = std::lround(q.x()), y = std::lround(q.y());
    if (x >= 0 && y >= 0 && x < width && y < height)
      image(static_cast<int>(x), static_cast<int>(y)) = 1000.0f * d.fit->deviation_mm[i];
  }
  return image;
}

std::string cloud_html(const Deviations& d, const MapStyle& style) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(d.fit->index.size());
  for (std::size_t i : d.fit->index) points.push_back(d.measurement->cloud.p_world_mm[i]);
  report::CloudCanvas canvas;
  canvas.style = style;
  canvas.label = "measured points, coloured by deviation";
  return report::cloud_canvas_html(points, in_um(*d.fit), canvas,
                                   fmt::format("cloud-{}-{}", d.fit->object, d.side));
}

std::string side_maps(const std::filesystem::path& dir, const Lens& lens, const Deviations& d,
                      const MapStyle& style) {
  const ImageF image = deviation_image(d, lens.width(), lens.height());
  report::write_map_png(dir / fmt::format("deviation_{}_{}.png", d.fit->object, d.side), image, style);
  return "<div class=\"maps\">" +
         titled_map(std::string(d.side) + ": camera view",
                    report::map_html(crop(image, data_window(finite_mask(image))), style)) +
         titled_map(std::string(d.side) + ": points", cloud_html(d, style)) + "</div>";
}

Plot deviation_histogram(const std::vector<Deviations>& sides, const report::MapLimits& limits) {
  Plot plot{.x_label = "deviation from the fitted surface [µm]",
            .y_label = "share of points [%]",
            .height_px = 260,
            .x_range = {{limits.low, limits.high}}};
  for (const Deviations& d : sides)
    plot.series.push_back(report::histogram_series(
        report::histogram(in_um(*d.fit), 121, limits.low, limits.high), d.side, d.color));
  return plot;
}

report::MapLimits common_limits(const std::vector<Deviations>& sides, double percent) {
  std::vector<const ObjectFit*> fits;
  for (const Deviations& d : sides) fits.push_back(d.fit);
  const double span_um = deviation_span_um(fits, percent);
  return {-span_um, span_um};
}

}  // namespace

std::string deviation_html(const std::filesystem::path& dir, const Twin& twin, const std::string& command,
                           const std::string& object, const std::vector<MeasuredSide>& measured) {
  std::vector<Deviations> sides;
  for (const MeasuredSide& side : measured)
    if (const ObjectFit* fit = fit_with_deviations(*side.measurement, object))
      sides.push_back({side.measurement, fit, side.name, side.color});
  if (sides.empty()) return "";
  const MapStyle style{.scale = Scale::diverging,
                       .limits = common_limits(sides, kDeviationPercent),
                       .unit = "µm",
                       .title = "deviation"};
  std::string maps, n;
  for (const Deviations& d : sides) {
    maps += side_maps(dir, twin.cameras.front().lens, d, style);
    n += fmt::format("{}{} n = {}", n.empty() ? "" : ", ", d.side, report::count(d.fit->index.size()));
  }
  const std::string plot = report::plots_or_sentences(
      {deviation_histogram(sides, common_limits(sides, 99.8))}, "dev-" + object)[0];
  const auto figure = [&](const std::string& body, const std::string& caption) {
    return report::figure_html(body, caption, "", command);
  };
  return "<h3>" + report::escape_html(object) + "</h3>\n" +
         figure(maps, fmt::format("{}: signed distance of the measured points from the fitted {}, positive "
                                  "outside; {}. Colours span the 99th percentile of |deviation|.",
                                  object, sides.front().fit->kind, n)) +
         figure(plot, fmt::format("{}: signed histogram of the deviation ({}).", object, n));
}

std::string geometry_figures_html(const ReportInput& in) {
  std::vector<MeasuredSide> sides;
  if (in.simulated.measurement)
    sides.push_back({&*in.simulated.measurement, "simulated", report::color::kSimulated});
  if (in.real.measurement) sides.push_back({&*in.real.measurement, "real", report::color::kReal});
  std::string html;
  for (const FitRow& row : in.comparison.fits)
    html += deviation_html(in.dir, in.twin, in.command, row.object, sides);
  return html;
}

}  // namespace fringetwin::compare
