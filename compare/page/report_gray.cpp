// SPDX-License-Identifier: Apache-2.0
// Images side by side and the gray row profile (the paper's Fig. 17).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/gray/gray_rows.hpp"
#include "compare/page/report_gain.hpp"
#include "compare/page/report_parts.hpp"
#include "report/map.hpp"
#include "report/plot/plot.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using report::MapStyle;
using report::Plot;
using report::Scale;

/// Returns the index of the image shown: finest pitch of the first direction, first compared step; else the
/// first image.
int shown_image(const Twin& twin, const std::vector<int>& candidates) {
  const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
  const int finest = twin.fringes.directions.front().finest();
  for (int i : candidates) {
    const PatternSpec& p = patterns[i];
    if (!p.is_gray() && !p.is_image() && p.direction == 0 && p.pitch == finest) return i;
  }
  return candidates.empty() ? 0 : candidates.front();
}

std::string label_of(const Twin& twin, int image) {
  return expand_sequence(twin.fringes)[image].label(twin.fringes);
}

/// Draws the whole row, its difference, and the middle of it enlarged with what it was before the gain fit.
std::vector<Plot> profile_plots(const ImageF& real, const ImageF& before, const ImageF& predicted,
                                const ImageF& difference, int row, const Columns& whole) {
  const int middle = (whole.first + whole.second) / 2;
  const int half = std::min(70, (whole.second - whole.first) / 4 + 10);
  const Columns enlarged{middle - half, middle + half};
  const auto sides = [&](const Columns& columns, double width) {
    return row_plot(
        "gray value [DN]", 290, columns,
        {row_series(real, row, columns, "real", report::color::kReal, width),
         row_series(predicted, row, columns, "simulated, after gain fit", report::color::kSimulated, width)});
  };
  Plot zoom = sides(enlarged, 1.8);
  if (!before.empty()) {
    zoom.series.push_back(
        row_series(before, row, enlarged, "simulated, before gain fit", report::color::kThird));
    zoom.series.back().style = report::Series::Style::dashed;
  }
  Plot residual = row_plot("simulated − real [DN]", 220, whole,
                           {row_series(difference, row, whole, "", report::color::kDifference, 1.0)});
  residual.zero_line = true;
  return {sides(whole, 1.0), residual, zoom};
}

/// Returns what the twin's own sensor makes of it, before any fit; empty where the real side is irradiance.
ImageF gray_before_fit(const GrayPair& pair, const GainFit& fit, int image) {
  if (pair.real->radiance) return {};
  if (pair.simulated && !pair.simulated->radiance) return pair.simulated->images[image].floats();
  GainFit twin = fit;
  twin.row.gain_dn = pair.camera->sensor.gain_dn;
  twin.row.black_level_dn = pair.camera->sensor.black_level_dn;
  return predicted_gray(pair, twin, image);
}

MapStyle gray_style(double max_dn, const std::string& title) {
  return {.scale = Scale::gray, .limits = {0.0, max_dn}, .unit = "DN", .title = title, .max_width_px = 720};
}

double brightest(const ImageF& image) { return std::max(1.0, report::robust_limits(image, 0.0, 99.9).high); }

std::string camera_with_real(const ReportInput& in, const GrayPair& pair, const GainFit& fit, std::size_t c) {
  const int image = shown_image(in.twin, pair.images);
  const std::string name = pair.camera->name, label = label_of(in.twin, image);
  const ImageF real = pair.real->images[image].floats();
  const ImageF predicted = predicted_gray(pair, fit, image), difference = gray_difference(pair, fit, image);
  const auto [window, row, columns] = shown_part(in, c);
  const MapStyle signed_style = difference_style(difference, "DN");
  report::write_map_png(in.dir / ("gray_difference_" + name + ".png"), difference, signed_style);

  std::vector<Plot> plots =
      profile_plots(real, gray_before_fit(pair, fit, image), predicted, difference, row, columns);
  for (Plot& plot : gain_plots(pair, fit)) plots.push_back(std::move(plot));
  const std::vector<std::string> svg = report::plots_or_sentences(plots, "gray-" + name);

  const ImageF real_part = crop(real, window), predicted_part = crop(predicted, window);
  std::string html = camera_heading(name);
  html += figure_html(
      in,
      "<div class=\"maps\">" +
          report::slider_html(real_part, "real", predicted_part, "simulated",
                              gray_style(brightest(real_part), label), "slider-" + name) +
          report::map_html(crop(difference, window), signed_style) + "</div>",
      fmt::format("{}, {}, {}: real and simulated image (after the gain fit) with slider, and the "
                  "signed difference; gray where a value is saturated, near a clip or not "
                  "decoded. Full resolution: gray_difference_{}.png.",
                  name, label, window.text(), name),
      "d = gain · E_sim + black_level − DN_real");
  html += figure_html(
      in, svg[0] + svg[1] + svg[2],
      fmt::format("{}, {}: gray values along image row {} (compare the paper's Fig. 17), their "
                  "difference, and the middle of the row enlarged, there also before the gain fit.",
                  name, label, row));
  if (svg.size() > 3)
    html +=
        figure_html(in, svg[3] + svg[4],
                    fmt::format("{}: real gray values against simulated irradiance over all compared phase "
                                "steps, in 80 bins, the fitted line, and what it leaves.",
                                name),
                    "DN = gain · E + black_level");
  return html;
}

std::string camera_simulated_only(const ReportInput& in, std::size_t c) {
  const CameraImages& images = in.simulated.images.at(c);
  if (images.images.empty()) return "";
  std::vector<int> all(images.images.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const int image = shown_image(in.twin, all);
  const ImageF picture = images.images[image].floats();
  const auto [window, row, columns] = shown_part(in, c);
  const std::string label = label_of(in.twin, image);
  Plot plot = row_plot("gray value [DN]", 290, columns,
                       {row_series(picture, row, columns, "simulated", report::color::kSimulated, 1.0)});
  plot.width_px = 680;
  const ImageF part = crop(picture, window);
  const std::string svg = report::plots_or_sentences({plot}, "gray-" + images.camera)[0];
  return camera_heading(images.camera) +
         figure_html(in,
                     "<div class=\"maps\">" + report::map_html(part, gray_style(brightest(part), label)) +
                         "<div class=\"wide\">" + svg + "</div></div>",
                     fmt::format("{}, {}: simulated image ({}) and its gray values along image row {}.",
                                 images.camera, label, window.text(), row));
}

}  // namespace

std::string gray_figures_html(const ReportInput& in) {
  std::vector<std::string> ignored;
  const std::vector<GrayPair> pairs = pair_gray(in.twin, in.real, in.simulated, in.options, ignored);
  std::string html;
  for (std::size_t c = 0; c < pairs.size() && c < in.comparison.gain.size(); ++c) {
    const GainFit fit = fit_of(pairs[c], in.comparison.gain[c]);
    if (!fit.has_line()) continue;
    html += camera_with_real(in, pairs[c], fit, c);
  }
  if (!html.empty() || in.has_real_images()) return html;
  for (std::size_t c = 0; c < in.simulated.images.size(); ++c) html += camera_simulated_only(in, c);
  if (html.empty()) return html;
  return "<p>There are no real images for this twin: the simulated ones are shown alone.</p>\n" + html;
}

std::string held_out_figures_html(const ReportInput& in) {
  std::string html;
  for (const HeldOutMap& map : in.options.held_out_worst) {
    const MapStyle style = difference_style(map.sigmas, "standard deviations");
    const std::string file = "held_out_" + map.camera + ".png";
    report::write_map_png(in.dir / file, map.sigmas, style);
    html += camera_heading(map.camera) +
            figure_html(in, "<div class=\"maps\">" + report::map_html(map.sigmas, style) + "</div>",
                        fmt::format("{}, {}: the held-out image that is predicted worst, {:.3f} times what "
                                    "noise and the fit predict. Where the twin is right it is noise of 1 "
                                    "without any pattern. One value per {} px; gray where none is used. {}.",
                                    map.camera, map.pattern, map.ratio, map.stride_px, file),
                        "(predicted − real) / √(noise² + fit²)");
  }
  return html;
}

}  // namespace fringetwin::compare
