// SPDX-License-Identifier: Apache-2.0
// Makes the page of `fringetwin needs`: tables and bar charts of what each effect of the scene (shadow, blur,
// noise ...) changes in phase, gray value and fit, what it costs, and which effects can be left off.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "report/html_page.hpp"
#include "report/plot/plot.hpp"
#include "report/table.hpp"
#include "report/text.hpp"
#include "tradeoff/needs.hpp"
#include "tradeoff/tradeoff_json.hpp"

namespace fringetwin::tradeoff {
namespace {

using report::Plot, report::Series, report::text_column;

std::string effects_table(const NeedsResult& result) {
  report::Table table;
  table.caption = "What each effect of the scene changes: the full model against the same model without it.";
  table.columns = {text_column("effect"), text_column("without it"),       {"phase", "rad rms"},
                   {"gray", "DN rms"},    {"gray at edges", "DN rms"},     {"fit", "mm"},
                   {"time", "× without"}, text_column("for the tolerance")};
  for (const EffectRow& r : result.rows)
    if (r.on)
      table.add_row({r.name, r.without, scientific(r.change.phase_rms_rad), scientific(r.change.gray_rms_dn),
                     scientific(r.change.gray_edge_rms_dn), scientific(r.fit_change_mm()),
                     report::fixed(r.cost, 2), r.leave_off ? "can be left off" : "keep"});
  table.add_row({"renderer's own error", "double-precision reference", scientific(result.floor.phase_rms_rad),
                 scientific(result.floor.gray_rms_dn), scientific(result.floor.gray_edge_rms_dn), "", "", ""},
                "group");
  return table.html();
}

std::string off_table(const NeedsResult& result) {
  report::Table table;
  table.caption = "Effects the scene does not ask for: they cost nothing, and nothing is invented for them.";
  table.columns = {text_column("effect"), text_column("to switch it on, in twin.toml")};
  for (const EffectRow& r : result.rows)
    if (!r.on) table.add_row({r.name, r.switch_on});
  return table.rows.empty() ? "" : table.html();
}

std::string summary(const NeedsResult& result, const NeedsOptions& options) {
  std::string left_off;
  for (const EffectRow& r : result.rows)
    if (r.leave_off) left_off += (left_off.empty() ? "" : ", ") + r.name;
  report::Table table;
  table.columns = {text_column("smallest model"), {"phase", "rad rms"}, {"gray", "DN rms"}, {"fit", "mm"}};
  table.add_row({"tolerance", scientific(options.tolerance.phase_rad), scientific(options.tolerance.gray_dn),
                 scientific(options.tolerance.fit_mm)});
  table.add_row({left_off.empty() ? "nothing can be left off" : "without " + left_off,
                 scientific(result.reduced.phase_rad), scientific(result.reduced.gray_dn),
                 scientific(result.reduced.fit_mm)});
  return table.html() + fmt::format("<p>Time of the whole images: {} s instead of {} s.</p>",
                                    report::number(result.reduced_time.wall_s, 3),
                                    report::number(result.full_time.wall_s, 3));
}

/// Draws one bar per effect that is on, the tolerance and the renderer's own error as lines.
Plot bars(const NeedsResult& result, const std::string& y_label, const std::string& color,
          const std::function<double(const EffectRow&)>& value, double tolerance, double floor) {
  Plot plot{.y_label = y_label, .log_y = true, .height_px = 260};
  Series series{.title = "change", .style = Series::Style::bars, .color = color};
  double x = 0.0, low = tolerance, high = tolerance;
  for (const EffectRow& r : result.rows) {
    if (!r.on) continue;
    plot.x_tics.emplace_back(++x, r.name);
    const double v = value(r);
    if (!std::isfinite(v) || v <= 0.0) continue;  // no change at all has no place on a log scale
    series.add(x, v);
    low = std::min(low, std::max(v, 1e-6 * tolerance));  // what is that small needs no exact bar
    high = std::max(high, v);
  }
  const auto line = [&](const std::string& title, double level, Series::Style style, const char* line_color) {
    if (!std::isfinite(level) || level <= 0.0) return;
    low = std::min(low, level);
    plot.series.push_back(
        {.title = title, .x = {0.4, x + 0.6}, .y = {level, level}, .style = style, .color = line_color});
  };
  plot.series.push_back(series);
  line("tolerance", tolerance, Series::Style::line, report::color::kDifference);
  line("renderer's own error", floor, Series::Style::dashed, report::color::kThird);
  plot.x_range = {0.4, x + 0.6};
  plot.y_range = {std::pow(10.0, std::floor(std::log10(low) - 0.3)),
                  std::pow(10.0, std::ceil(std::log10(high)))};
  return plot;
}

Plot cost_bars(const NeedsResult& result) {
  Plot plot{.y_label = "time with / without", .log_y = true, .height_px = 260};
  Series series{.title = "cost", .style = Series::Style::bars, .color = report::color::kFourth};
  double x = 0.0, high = 2.0;
  for (const EffectRow& r : result.rows) {
    if (!r.on) continue;
    plot.x_tics.emplace_back(++x, r.name);
    series.add(x, r.cost);
    high = std::max(high, r.cost);
  }
  plot.series = {series,
                 {.title = "no cost",
                  .x = {0.4, x + 0.6},
                  .y = {1.0, 1.0},
                  .style = Series::Style::line,
                  .color = report::color::kDifference}};
  plot.x_range = {0.4, x + 0.6};
  plot.y_range = {0.5, 1.3 * high};
  return plot;
}

std::string charts(const NeedsResult& result, const NeedsOptions& options) {
  const double none = std::nan("");
  std::vector<Plot> plots{bars(
                              result, "phase [rad rms]", report::color::kReal,
                              [](const EffectRow& r) { return r.change.phase_rms_rad; },
                              options.tolerance.phase_rad, result.floor.phase_rms_rad),
                          bars(
                              result, "gray [DN rms]", report::color::kSimulated,
                              [](const EffectRow& r) { return r.change.gray_rms_dn; },
                              options.tolerance.gray_dn, result.floor.gray_rms_dn)};
  if (result.has_fits)
    plots.push_back(bars(
        result, "fit [mm]", report::color::kThird, [](const EffectRow& r) { return r.fit_change_mm(); },
        options.tolerance.fit_mm, none));
  plots.push_back(cost_bars(result));
  const std::vector<std::string> svgs = report::plots_or_sentences(plots, "needs");
  std::string out;
  const auto figure = [&out](const std::string& body, const std::string& caption,
                             const std::string& formula) {
    out += report::figure_html(body, caption, formula);
  };
  std::size_t k = 0;
  figure(svgs[k++],
         "Phase at the finest pitch: rms over the subset's modulated pixels of the change each effect makes.",
         "rms(arg(F_with · conj(F_without))),  F = 2/N Σ I_n exp(-2πi n/N)");
  figure(svgs[k++],
         "Gray level: rms over the subset's pixels and all images. Effects of light are compared before the "
         "sensor, effects of the sensor after it.",
         "rms(DN_with - DN_without)");
  if (result.has_fits)
    figure(svgs[k++],
           "Fitted quantities, through decoding, triangulation and fit of the whole images: the largest "
           "change of place, size and residual rms over all fitted objects.",
           "");
  figure(svgs[k++],
         fmt::format("Cost: {} of the whole images with the effect over that without it, both measured in "
                     "turns in one run.",
                     result.device.is_cpu ? "CPU time" : "wall time"),
         "");
  return out;
}

}  // namespace

std::string needs_html(const Twin& twin, const NeedsResult& result, const NeedsOptions& options,
                       const compare::Provenance& provenance) {
  report::Page page;
  page.title = "What “" + twin.name + "” needs";
  page.subtitle = fmt::format("{} camera(s), {} images each, on {}", twin.cameras.size(),
                              expand_sequence(twin.fringes).size(), result.device.name);
  page.summary_html = summary(result, options);
  page.note = "Pixels looked at: " + result.subset.text() + ".";
  page.warnings = result.warnings;
  page.sections = {{"effects", "Effects", effects_table(result)},
                   {"charts", "Against the tolerance", charts(result, options)}};
  const std::string off = off_table(result);
  if (!off.empty()) page.sections.push_back({"off", "Off in this scene", off});
  page.footer_html = provenance_html(twin, provenance, result.device);
  return page.html();
}

}  // namespace fringetwin::tradeoff
