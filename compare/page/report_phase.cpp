// SPDX-License-Identifier: Apache-2.0
// Phase maps, their difference and a row profile (the paper's Fig. 18).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/page/report_parts.hpp"
#include "compare/phase/phase_rows.hpp"
#include "report/map.hpp"
#include "report/plot.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;
using report::MapStyle;
using report::Plot;
using report::Scale;
using report::Series;

MapStyle phase_style(const ImageF& phase, const std::string& title) {
  MapStyle style;
  style.scale = Scale::viridis;
  style.limits = report::robust_limits(phase, 0.5, 99.5);
  style.unit = "rad";
  style.title = title;
  style.max_width_px = 520;
  return style;
}

Plot row_plot(const std::string& y_label, int height_px, const std::pair<int, int>& extent) {
  Plot plot;
  plot.x_label = "image column [px]";
  plot.y_label = y_label;
  plot.height_px = height_px;
  plot.x_range = {{extent.first - 12, extent.second + 12}};
  return plot;
}

Series row_series(const ImageF& image, int row, const std::pair<int, int>& extent, const std::string& title,
                  const std::string& color, Series::Style style = Series::Style::line) {
  const RowData data = row_data(image, row, extent.first - 12, extent.second + 12);
  Series s;
  s.title = title;
  s.x = data.x_px;
  s.y = data.value;
  s.color = color;
  s.style = style;
  return s;
}

Plot difference_histogram(const ImageF& difference) {
  const report::MapLimits limits = report::symmetric_limits(difference, 99.8);
  Plot plot;
  plot.x_label = "phase difference, simulated − real [rad]";
  plot.y_label = "share of pixels [%]";
  plot.height_px = 240;
  plot.series = {report::histogram_series(report::histogram(difference.data, 121, limits.low, limits.high),
                                          "", report::color::kReal)};
  plot.x_range = {{limits.low, limits.high}};
  return plot;
}

std::string both_sides(const ReportInput& in, std::size_t c, const DirectionDecode& real,
                       const DirectionDecode& simulated) {
  const std::string name = in.twin.cameras[c].name, axis = axis_name(real.axis);
  const ImageF difference = phase_difference(real, simulated);
  const ImageF phase_real = absolute_phase(in.twin, real), phase_sim = absolute_phase(in.twin, simulated);
  MapStyle signed_style;
  signed_style.scale = Scale::diverging;
  signed_style.limits = report::symmetric_limits(difference);
  signed_style.unit = "rad";
  signed_style.title = "simulated − real";
  signed_style.max_width_px = 720;
  const std::string file = fmt::format("phase_difference_{}_{}.png", name, axis);
  report::write_map_png(in.dir / file, difference, signed_style);

  const ImageU8 mask = valid_mask(in, c);
  const Window window = data_window(mask);
  const int row = profile_row(in, c, mask);
  const auto extent = row_extent(mask, row);
  Plot profile = row_plot("absolute phase [rad]", 270, extent);
  profile.series = {
      row_series(phase_real, row, extent, "real", report::color::kReal),
      row_series(phase_sim, row, extent, "simulated", report::color::kSimulated, Series::Style::dashed)};
  Plot residual = row_plot("simulated − real [rad]", 210, extent);
  residual.series = {row_series(difference, row, extent, "", report::color::kDifference)};
  residual.zero_line = true;
  const std::vector<std::string> svg = report::plots_or_sentences(
      {profile, residual, difference_histogram(difference)}, "phase-" + name + "-" + axis);
  const ImageF part = crop(phase_real, window);
  const MapStyle style = phase_style(part, "absolute phase");
  return figure(in,
                "<div class=\"maps\"><div class=\"map\"><h4>real</h4>" + report::map_html(part, style) +
                    "</div><div class=\"map\"><h4>simulated</h4>" +
                    report::map_html(crop(phase_sim, window), style) +
                    "</div><div class=\"map\"><h4>difference</h4>" +
                    report::map_html(crop(difference, window), signed_style) + "</div></div>",
                fmt::format("{}, direction {}, {}: absolute phase at the finest pitch on both sides and the "
                            "difference. Full resolution: {}.",
                            name, axis, window.text(), file),
                "Φ = 2π (x_projector − phase_origin) / pitch;  ΔΦ = Φ_sim − Φ_real")
             .html() +
         figure(in, svg[0] + svg[1],
                fmt::format("{}, direction {}: absolute phase along image row {} (compare the paper's Fig. "
                            "18) and the difference.",
                            name, axis, row),
                "")
             .html() +
         figure(in, svg[2],
                fmt::format("{}, direction {}: signed histogram of the phase difference.", name, axis), "")
             .html();
}

std::string one_side(const ReportInput& in, std::size_t c, const DirectionDecode& decode, const char* side) {
  const std::string name = in.twin.cameras[c].name, axis = axis_name(decode.axis);
  const ImageF phase = absolute_phase(in.twin, decode);
  const ImageU8 mask = valid_mask(in, c);
  const Window window = data_window(mask);
  const int row = profile_row(in, c, mask);
  const auto extent = row_extent(mask, row);
  Plot profile = row_plot("absolute phase [rad]", 270, extent);
  profile.series = {row_series(phase, row, extent, side, report::color::kSimulated)};
  profile.width_px = 680;
  const ImageF part = crop(phase, window);
  return figure(in,
                "<div class=\"maps\">" + report::map_html(part, phase_style(part, "absolute phase")) +
                    "<div class=\"wide\">" +
                    report::plots_or_sentences({profile}, "phase-" + name + "-" + axis)[0] + "</div></div>",
                fmt::format(
                    "{}, direction {}, {}: {} absolute phase at the finest pitch, and along image row {}.",
                    name, axis, window.text(), side, row),
                "Φ = 2π (x_projector − phase_origin) / pitch")
      .html();
}

}  // namespace

std::string phase_figures_html(const ReportInput& in) {
  std::string html;
  for (std::size_t c = 0; c < in.twin.cameras.size(); ++c) {
    const auto decode = [&](const Side& side) -> const measure::CameraDecode* {
      return side.measurement && c < side.measurement->cameras.size() ? &side.measurement->cameras[c]
                                                                      : nullptr;
    };
    const measure::CameraDecode *real = decode(in.real), *simulated = decode(in.simulated);
    const measure::CameraDecode* any = simulated ? simulated : real;
    if (!any) continue;
    html += camera_heading(any->camera);
    for (const DirectionDecode& d : any->directions) {
      if (d.coordinate_px.empty() || d.pitches_px.empty()) continue;
      const DirectionDecode* other = real && simulated ? real->direction(d.axis) : nullptr;
      html += other && !other->coordinate_px.empty() ? both_sides(in, c, *other, d)
                                                     : one_side(in, c, d, simulated ? "simulated" : "real");
    }
  }
  return html;
}

}  // namespace fringetwin::compare
