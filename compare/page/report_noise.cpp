// SPDX-License-Identifier: Apache-2.0
// Makes the page's section on noise: rows of measured and predicted noise go in; a table, plots over gray
// level and quantile, and a map of the ratio come out as HTML.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/page/report_parts.hpp"
#include "report/map.hpp"
#include "report/plot/plot.hpp"
#include "report/table.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

using report::fixed;
using report::Plot;
using report::Series;
using report::text_column;

std::string noise_table_html(const std::vector<NoiseRow>& rows) {
  report::Table table;
  table.caption =
      "Standard deviations of the real images and what the twin's sensor predicts; ratio = measured / "
      "predicted, each value by its own prediction.";
  table.columns = {text_column("camera"),
                   text_column("noise of"),
                   text_column("predicted from"),
                   {"measured"},
                   {"predicted"},
                   {"ratio"},
                   {"n"}};
  for (const NoiseRow& r : rows) {
    const std::string source = r.sensor_known ? "sensor and rounding" : "rounding alone";
    table.add_row({r.camera, r.direction + ": gray values", source, fixed(r.gray_measured_dn, 3) + " DN",
                   fixed(r.gray_predicted_dn, 3) + " DN",
                   report::with_sigma(r.gray_ratio, r.gray_ratio_sigma), report::count(r.n)});
    table.add_row({r.camera, r.direction + ": phase", source, fixed(r.phase_measured_rad, 4) + " rad",
                   fixed(r.phase_predicted_rad, 4) + " rad",
                   report::with_sigma(r.phase_ratio, r.phase_ratio_sigma), report::count(r.n_phase)});
  }
  return table.html();
}

std::string source_text(const NoiseRow& row) {
  if (row.source == "pitches")
    return "differences between the pitches of the means of their three steps, which hold no fringe";
  if (row.source == "neighbours")
    return "the mean of the three steps, which holds no fringe; with one pitch only neighbouring pixels tell "
           "its noise, so that fine texture may be in it";
  return fmt::format(
      "what the fit of mean, cosine and sine to the {} steps leaves ({} degree{} of freedom per pixel{})",
      row.steps, row.steps - 3, row.steps == 4 ? "" : "s",
      row.steps == 4 ? ", the alternating sum with its sign" : "");
}

std::string explanation_html(const std::vector<NoiseRow>& rows) {
  std::string html = fmt::format(
      "<p>Gray: {}, differentiated twice along the stripes, where harmonics are smooth. Phase: second "
      "differences of the real phase along the stripes at the finest pitch. A ratio of 1 says that the twin "
      "is as noisy as the rig; a phase ratio above the gray one is texture or shape, not sensor.</p>",
      source_text(rows.front()));
  if (!std::ranges::all_of(rows, [](const NoiseRow& r) { return r.sensor_known; }))
    html +=
        "<p>The twin's sensor has no noise (no <code>electrons_per_dn</code>, no "
        "<code>read_noise_dn</code>): the prediction is the rounding to whole gray values alone. "
        "<code>fringetwin photometry</code> measures both from these images.</p>";
  return html;
}

Plot level_plot(const NoiseRow& row) {
  Series measured, predicted;
  measured.style = Series::Style::points;
  measured.title = "measured";
  predicted.title = row.sensor_known ? "predicted by the sensor model" : "rounding alone";
  predicted.color = report::color::kSimulated;
  for (const NoiseLevel& l : row.levels) {
    measured.add(l.level_dn, l.measured_dn);
    predicted.add(l.level_dn, l.predicted_dn);
  }
  double top = 0.0;
  for (const Series* s : {&measured, &predicted})
    for (const double v : s->y) top = std::max(top, v);
  return {.x_label = "mean gray value [DN]",
          .y_label = "gray noise [DN]",
          .series = {measured, predicted},
          .width_px = 620,
          .height_px = 300,
          .y_range = {{0.0, std::max(1.15 * top, 1e-3)}}};
}

Plot quantile_plot(const NoiseRow& row) {
  Series points, normal, scaled;
  points.style = Series::Style::points;
  points.title = "residuals";
  points.width = 1.0;
  points.x = row.normal_quantile;
  points.y = row.residual_quantile;
  normal.title = "as predicted";
  normal.color = report::color::kSimulated;
  scaled.title = "normal, measured ratio";
  scaled.style = Series::Style::dashed;
  scaled.color = report::color::kDifference;
  for (const double q : row.normal_quantile) {
    normal.add(q, q);
    scaled.add(q, row.gray_ratio * q);
  }
  return {.x_label = "normal quantile",
          .y_label = "residual / predicted sigma",
          .series = {points, normal, scaled},
          .width_px = 620,
          .height_px = 300};
}

std::string noise_figures_html(const ReportInput& in, const NoiseRow& row) {
  const std::string id = row.camera + "-" + row.direction;
  const std::vector<std::string> svg =
      report::plots_or_sentences({level_plot(row), quantile_plot(row)}, "noise-" + id);
  report::MapStyle style{.scale = report::Scale::viridis,
                         .limits = report::robust_limits(row.ratio_map),
                         .title = "measured / predicted gray noise",
                         .max_width_px = 480};
  const Window window = shown_part(in, camera_index(in, row.camera)).window;
  const ImageF map = crop(enlarged_blocks(row.ratio_map, kNoiseBlock), window);
  return figure_html(
      in,
      "<div class=\"maps\"><div class=\"map\">" + svg[0] + "</div><div class=\"map\">" + svg[1] +
          "</div></div>" + report::map_html(map, style),
      fmt::format("{}, direction {}: gray noise over gray level; quantiles of the residuals over their "
                  "predicted sigma against the normal distribution; ratio in blocks of {} × {} px.",
                  row.camera, row.direction, kNoiseBlock, kNoiseBlock),
      "sigma² = (DN − black) / electrons_per_dn + read_noise² + 1/12;  sigma_phase = sqrt(2/N) "
      "sigma / amplitude");
}

}  // namespace

std::string noise_html(const ReportInput& in) {
  const std::vector<NoiseRow>& rows = in.comparison.noise;
  if (rows.empty()) return "";
  std::string html = noise_table_html(rows) + explanation_html(rows);
  for (const NoiseRow& row : rows) html += noise_figures_html(in, row);
  return html;
}

}  // namespace fringetwin::compare
