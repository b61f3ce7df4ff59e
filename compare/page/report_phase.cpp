// SPDX-License-Identifier: Apache-2.0
// Phase maps, their difference and a row profile (the paper's Fig. 18).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/page/report_parts.hpp"
#include "compare/phase/phase_rows.hpp"
#include "report/map.hpp"
#include "report/plot/plot.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;
using report::MapStyle;
using report::Plot;
using report::Scale;

MapStyle phase_style(const ImageF& phase, const std::string& title) {
  return {.scale = Scale::viridis,
          .limits = report::robust_limits(phase, 0.5, 99.5),
          .unit = "rad",
          .title = title,
          .max_width_px = 520};
}

Plot difference_histogram(const ImageF& difference) {
  const report::MapLimits limits = report::symmetric_limits(difference, 99.8);
  return {.x_label = "phase difference, simulated − real [rad]",
          .y_label = "share of pixels [%]",
          .series = {report::histogram_series(
              report::histogram(difference.data, 121, limits.low, limits.high), "", report::color::kReal)},
          .height_px = 240,
          .x_range = {{limits.low, limits.high}}};
}

std::string both_sides(const ReportInput& in, std::size_t c, const DirectionDecode& real,
                       const DirectionDecode& simulated) {
  const std::string name = in.twin.cameras[c].name, axis = axis_name(real.axis);
  const ImageF difference = phase_difference(real, simulated);
  const ImageF phase_real = absolute_phase(in.twin, real), phase_sim = absolute_phase(in.twin, simulated);
  const MapStyle signed_style = difference_style(difference, "rad");
  const std::string file = fmt::format("phase_difference_{}_{}.png", name, axis);
  report::write_map_png(in.dir / file, difference, signed_style);

  const auto [window, row, columns] = shown_part(in, c);
  Plot profile = row_plot("absolute phase [rad]", 270, columns,
                          {row_series(phase_real, row, columns, "real", report::color::kReal),
                           row_series(phase_sim, row, columns, "simulated", report::color::kSimulated)});
  profile.series.back().style = report::Series::Style::dashed;
  Plot residual = row_plot("simulated − real [rad]", 210, columns,
                           {row_series(difference, row, columns, "", report::color::kDifference)});
  residual.zero_line = true;
  const std::vector<std::string> svg = report::plots_or_sentences(
      {profile, residual, difference_histogram(difference)}, "phase-" + name + "-" + axis);
  const ImageF part = crop(phase_real, window);
  const MapStyle style = phase_style(part, "absolute phase");
  return figure_html(
             in,
             "<div class=\"maps\">" + titled_map("real", report::map_html(part, style)) +
                 titled_map("simulated", report::map_html(crop(phase_sim, window), style)) +
                 titled_map("difference", report::map_html(crop(difference, window), signed_style)) +
                 "</div>",
             fmt::format("{}, direction {}, {}: absolute phase at the finest pitch on both sides and the "
                         "difference. Full resolution: {}.",
                         name, axis, window.text(), file),
             "Φ = 2π (x_projector − phase_origin) / pitch;  ΔΦ = Φ_sim − Φ_real") +
         figure_html(
             in, svg[0] + svg[1],
             fmt::format("{}, direction {}: absolute phase along image row {} (compare the paper's Fig. "
                         "18) and the difference.",
                         name, axis, row)) +
         figure_html(in, svg[2],
                     fmt::format("{}, direction {}: signed histogram of the phase difference.", name, axis));
}

std::string one_side(const ReportInput& in, std::size_t c, const DirectionDecode& decode, const char* side) {
  const std::string name = in.twin.cameras[c].name, axis = axis_name(decode.axis);
  const ImageF phase = absolute_phase(in.twin, decode);
  const auto [window, row, columns] = shown_part(in, c);
  Plot profile = row_plot("absolute phase [rad]", 270, columns,
                          {row_series(phase, row, columns, side, report::color::kSimulated)});
  profile.width_px = 680;
  const ImageF part = crop(phase, window);
  return figure_html(
      in,
      "<div class=\"maps\">" + report::map_html(part, phase_style(part, "absolute phase")) +
          "<div class=\"wide\">" + report::plots_or_sentences({profile}, "phase-" + name + "-" + axis)[0] +
          "</div></div>",
      fmt::format("{}, direction {}, {}: {} absolute phase at the finest pitch, and along image row {}.",
                  name, axis, window.text(), side, row),
      "Φ = 2π (x_projector − phase_origin) / pitch");
}

}  // namespace

std::string phase_figures_html(const ReportInput& in) {
  std::string html;
  for (std::size_t c = 0; c < in.twin.cameras.size(); ++c) {
    const measure::CameraDecode *real = decode_of(in.real, c), *simulated = decode_of(in.simulated, c);
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
