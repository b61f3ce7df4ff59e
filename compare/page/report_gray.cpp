// SPDX-License-Identifier: Apache-2.0
// Images side by side and the gray row profile (the paper's Fig. 17).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/gray/gray_rows.hpp"
#include "compare/page/report_gain.hpp"
#include "compare/page/report_parts.hpp"
#include "report/map.hpp"
#include "report/plot.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using report::MapStyle;
using report::Plot;
using report::Scale;
using report::Series;

/// Returns the index of the image shown: finest pitch of the first direction, first compared step; else the
/// first image.
int shown_image(const Twin& twin, const std::vector<int>& candidates) {
  const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
  const int finest = twin.fringes.directions.front().finest();
  for (int i : candidates) {
    const PatternSpec& p = patterns[static_cast<std::size_t>(i)];
    if (!p.is_gray() && !p.is_image() && p.direction == 0 && p.pitch == finest) return i;
  }
  return candidates.empty() ? 0 : candidates.front();
}

std::string label_of(const Twin& twin, int image) {
  return expand_sequence(twin.fringes)[static_cast<std::size_t>(image)].label(twin.fringes);
}

Series line(const RowData& row, const std::string& title, const std::string& color, double width = 1.4) {
  Series s;
  s.title = title;
  s.x = row.x_px;
  s.y = row.value;
  s.color = color;
  s.width = width;
  return s;
}

Plot row_plot(const std::string& y_label, int height_px, std::vector<Series> series) {
  Plot plot;
  plot.x_label = "image column [px]";
  plot.y_label = y_label;
  plot.height_px = height_px;
  plot.series = std::move(series);
  return plot;
}

/// Draws the whole row, its difference, and the middle of it enlarged with what it was before the gain fit.
std::vector<Plot> profile_plots(const ImageF& real, const ImageF& before, const ImageF& predicted,
                                const ImageF& difference, int row, std::pair<int, int> extent) {
  const int margin = 12;
  const int first = extent.first - margin, last = extent.second + margin;
  const int middle = (extent.first + extent.second) / 2, half = std::min(70, (last - first) / 4 + 10);
  const auto pair = [&](int a, int b, double width) {
    return std::vector<Series>{
        line(row_data(real, row, a, b), "real", report::color::kReal, width),
        line(row_data(predicted, row, a, b), "simulated, after gain fit", report::color::kSimulated, width)};
  };
  Plot whole = row_plot("gray value [DN]", 290, pair(first, last, 1.0));
  Plot zoom = row_plot("gray value [DN]", 290, pair(middle - half, middle + half, 1.8));
  if (!before.empty()) {
    Series dashed = line(row_data(before, row, middle - half, middle + half), "simulated, before gain fit",
                         report::color::kThird, 1.4);
    dashed.style = Series::Style::dashed;
    zoom.series.push_back(dashed);
  }
  Plot residual =
      row_plot("simulated − real [DN]", 220,
               {line(row_data(difference, row, first, last), "", report::color::kDifference, 1.0)});
  residual.zero_line = true;
  for (Plot* plot : {&whole, &residual}) plot->x_range = {{first, last}};
  zoom.x_range = {{middle - half, middle + half}};
  return {whole, residual, zoom};
}

/// Returns what the twin's own sensor makes of it, before any fit; empty where the real side is irradiance.
ImageF gray_before_fit(const GrayPair& pair, const GainFit& fit, int image) {
  if (pair.real->radiance) return {};
  if (pair.simulated && !pair.simulated->radiance)
    return pair.simulated->images[static_cast<std::size_t>(image)];
  GainFit twin = fit;
  twin.row.gain_dn = pair.camera->sensor.gain_dn;
  twin.row.black_level_dn = pair.camera->sensor.black_level_dn;
  return predicted_gray(pair, twin, image);
}

MapStyle gray_style(double max_dn, const std::string& title) {
  MapStyle style;
  style.scale = Scale::gray;
  style.limits = {0.0, max_dn};
  style.unit = "DN";
  style.title = title;
  style.max_width_px = 720;
  return style;
}

double brightest(const ImageF& image) { return std::max(1.0, report::robust_limits(image, 0.0, 99.9).high); }

std::string camera_with_real(const ReportInput& in, const GrayPair& pair, const GainFit& fit, std::size_t c) {
  const int image = shown_image(in.twin, pair.images);
  const std::string name = pair.camera->name, label = label_of(in.twin, image);
  const ImageF& real = pair.real->images[static_cast<std::size_t>(image)];
  const ImageF predicted = predicted_gray(pair, fit, image), difference = gray_difference(pair, fit, image);
  const ImageU8 mask = valid_mask(in, c);
  const Window window = data_window(mask);
  MapStyle signed_style;
  signed_style.scale = Scale::diverging;
  signed_style.limits = report::symmetric_limits(difference);
  signed_style.unit = "DN";
  signed_style.title = "simulated − real";
  signed_style.max_width_px = 720;
  report::write_map_png(in.dir / ("gray_difference_" + name + ".png"), difference, signed_style);

  const int row = profile_row(in, c, mask);
  std::vector<Plot> plots = profile_plots(real, gray_before_fit(pair, fit, image), predicted, difference, row,
                                          row_extent(mask, row));
  for (Plot& plot : gain_plots(pair, fit)) plots.push_back(std::move(plot));
  const std::vector<std::string> svg = report::plots_or_sentences(plots, "gray-" + name);

  const ImageF real_part = crop(real, window), predicted_part = crop(predicted, window);
  std::string html = camera_heading(name);
  html += figure(in,
                 "<div class=\"maps\">" +
                     report::slider_html(real_part, "real", predicted_part, "simulated",
                                         gray_style(brightest(real_part), label), "slider-" + name) +
                     report::map_html(crop(difference, window), signed_style) + "</div>",
                 fmt::format("{}, {}, {}: real and simulated image (after the gain fit) with slider, and the "
                             "signed difference; gray where a value is saturated, near a clip or not "
                             "decoded. Full resolution: gray_difference_{}.png.",
                             name, label, window.text(), name),
                 "d = gain · E_sim + black_level − DN_real")
              .html();
  html +=
      figure(in, svg[0] + svg[1] + svg[2],
             fmt::format("{}, {}: gray values along image row {} (compare the paper's Fig. 17), their "
                         "difference, and the middle of the row enlarged, there also before the gain fit.",
                         name, label, row),
             "")
          .html();
  if (svg.size() > 3)
    html += figure(in, svg[3] + svg[4],
                   fmt::format("{}: real gray values against simulated irradiance over all compared phase "
                               "steps, in 80 bins, the fitted line, and what it leaves.",
                               name),
                   "DN = gain · E + black_level")
                .html();
  return html;
}

std::string camera_simulated_only(const ReportInput& in, std::size_t c) {
  const CameraImages& images = in.simulated.images.at(c);
  if (images.images.empty()) return "";
  std::vector<int> all(images.images.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const int image = shown_image(in.twin, all);
  const ImageF& picture = images.images[static_cast<std::size_t>(image)];
  const ImageU8 mask = valid_mask(in, c);
  const Window window = data_window(mask);
  const std::string label = label_of(in.twin, image);
  const int row = profile_row(in, c, mask);
  const auto [first, last] = row_extent(mask, row);
  Plot plot = row_plot(
      "gray value [DN]", 290,
      {line(row_data(picture, row, first - 12, last + 12), "simulated", report::color::kSimulated, 1.0)});
  plot.x_range = {{first - 12, last + 12}};
  plot.width_px = 680;
  const ImageF part = crop(picture, window);
  const std::string svg = report::plots_or_sentences({plot}, "gray-" + images.camera)[0];
  return camera_heading(images.camera) +
         figure(in,
                "<div class=\"maps\">" + report::map_html(part, gray_style(brightest(part), label)) +
                    "<div class=\"wide\">" + svg + "</div></div>",
                fmt::format("{}, {}: simulated image ({}) and its gray values along image row {}.",
                            images.camera, label, window.text(), row),
                "")
             .html();
}

}  // namespace

std::string gray_figures_html(const ReportInput& in) {
  std::vector<std::string> ignored;
  const std::vector<GrayPair> pairs = pair_gray(in.twin, in.real, in.simulated, in.options, ignored);
  std::string html;
  for (std::size_t c = 0; c < pairs.size() && c < in.comparison.gain.size(); ++c) {
    GainFit fit;
    fit.row = in.comparison.gain[c];
    if (!fit.row.usable) continue;
    fit.usable = usable_range(pairs[c], fit.row.gain_dn, fit.row.black_level_dn, 0.0);
    fit.usable.low_dn = fit.row.low_dn;
    fit.usable.high_dn = fit.row.high_dn;
    html += camera_with_real(in, pairs[c], fit, c);
  }
  if (!html.empty() || in.has_real_images()) return html;
  for (std::size_t c = 0; c < in.simulated.images.size(); ++c) html += camera_simulated_only(in, c);
  if (html.empty()) return html;
  return "<p>There are no real images for this twin: the simulated ones are shown alone.</p>\n" + html;
}

}  // namespace fringetwin::compare
