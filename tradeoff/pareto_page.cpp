// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "report/html_page.hpp"
#include "report/plot/plot.hpp"
#include "report/table.hpp"
#include "report/text.hpp"
#include "tradeoff/pareto.hpp"
#include "tradeoff/tradeoff_json.hpp"

namespace fringetwin::tradeoff {
namespace {

using report::Align, report::Plot, report::Series;

using Value = std::function<double(const ParetoPoint&)>;

struct Look {
  const char* color;
  int filled, open;  // gnuplot symbols: fp32, fp64
};

Look look_of(std::size_t rank) {
  static const std::vector<Look> looks{{report::color::kReal, 7, 6},
                                       {report::color::kSimulated, 9, 8},
                                       {report::color::kThird, 5, 4},
                                       {report::color::kFourth, 13, 12}};
  return looks[rank % looks.size()];
}

std::vector<std::string> families_of(const ParetoResult& result) {
  std::vector<std::string> names;
  for (const ParetoPoint& p : result.points)
    if (std::ranges::find(names, p.scheme.family) == names.end()) names.push_back(p.scheme.family);
  return names;
}

struct Axes {
  std::string x_label, y_label;
  Value x, y;
  bool ParetoPoint::*front;
};

Series front_line(const ParetoResult& result, const Axes& axes) {
  std::vector<const ParetoPoint*> front;
  for (const ParetoPoint& p : result.points)
    if (p.*axes.front) front.push_back(&p);
  std::ranges::sort(front,
                    [&](const ParetoPoint* a, const ParetoPoint* b) { return axes.x(*a) < axes.x(*b); });
  Series s{.title = "Pareto front", .style = Series::Style::dashed, .color = report::color::kDifference};
  // Steps: between two points of the front the cheaper one is what can be had.
  for (std::size_t i = 0; i < front.size(); ++i) {
    if (i > 0) s.add(axes.x(*front[i]), axes.y(*front[i - 1]));
    s.add(axes.x(*front[i]), axes.y(*front[i]));
  }
  return s;
}

/// Draws a mark around the points for which `chosen` holds.
Series mark(const ParetoResult& result, const Axes& axes, const std::string& label, bool Scheme::*chosen,
            int symbol, double size) {
  Series s{.title = "",
           .style = Series::Style::points,
           .color = report::color::kDifference,
           .width = size,
           .point_type = symbol};
  for (const ParetoPoint& p : result.points) {
    if (!(p.scheme.*chosen)) continue;
    s.add(axes.x(p), axes.y(p));
    s.labels.push_back(fmt::format("{}: {} {}", label, p.scheme.family, p.scheme.size()));
  }
  return s;
}

Plot error_plot(const ParetoResult& result, const Axes& axes) {
  Plot plot{.x_label = axes.x_label, .y_label = axes.y_label};
  plot.log_x = plot.log_y = true;
  plot.height_px = 460;
  plot.series.push_back(front_line(result, axes));
  const auto families = families_of(result);
  for (const bool precise : {false, true})
    for (std::size_t k = 0; k < families.size(); ++k) {
      const Look look = look_of(k);
      Series s{.title = families[k] + (precise ? " fp64" : " fp32"),
               .style = Series::Style::points,
               .color = look.color,
               .width = 3.6,
               .point_type = precise ? look.open : look.filled};
      for (const ParetoPoint& p : result.points) {
        if (p.is_precise() != precise || p.scheme.family != families[k]) continue;
        const double y = axes.y(p);
        s.add(axes.x(p), y > 0.0 ? y : std::nan(""));
        const bool marked = p.scheme.is_default || p.scheme.is_published;
        s.labels.push_back(precise || marked ? "" : p.scheme.size());
      }
      plot.series.push_back(s);
    }
  plot.series.push_back(mark(result, axes, "default", &Scheme::is_default, 6, 8.0));
  plot.series.push_back(mark(result, axes, "published", &Scheme::is_published, 4, 8.0));
  double low = INFINITY, high = 0.0;
  for (const ParetoPoint& p : result.points)
    if (const double x = axes.x(p); std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
  if (low < high) plot.x_range = {0.7 * low, 4.0 * high};  // room for the labels on the right
  return plot;
}

std::string notes_of(const ParetoPoint& p) {
  std::string notes, fronts;
  const auto note = [](std::string& text, bool holds, const std::string& what) {
    if (holds) text += (text.empty() ? "" : ", ") + what;
  };
  note(fronts, p.on_phase_front, "phase");
  note(fronts, p.on_gray_front, "gray");
  note(fronts, p.on_fit_front, "fit");
  note(notes, p.scheme.is_default, "default");
  note(notes, p.scheme.is_published, "published scheme");
  note(notes, !fronts.empty(), "front: " + fronts);
  note(notes, p.is_fit_reference, "reference of the fit shifts");
  note(notes, p.extrapolated_from > 0, fmt::format("time from {} samples", p.extrapolated_from));
  return notes;
}

std::string table(const ParetoResult& result) {
  report::Table t;
  t.columns = {{"scheme", "", Align::left}, {"frame", "ms"},
               {"phase inside", "rad rms"}, {"phase all", "rad rms"},
               {"gray inside", "DN rms"},   {"gray all", "DN rms"},
               {"gray edges", "DN rms"},    {"fit error", "µm"},
               {"fit shift", "µm"},         {"chain", "s"},
               {"", "", Align::left}};
  const auto um = [](double mm) {
    return std::isfinite(mm) ? report::number(1e3 * mm, 2) : std::string("–");
  };
  for (const ParetoPoint& p : result.points)
    t.add_row({p.name(), report::number(p.frame_ms, 3), scientific(p.error.phase_interior_rms_rad),
               scientific(p.error.phase_rms_rad), scientific(p.error.gray_interior_rms_dn),
               scientific(p.error.gray_rms_dn), scientific(p.error.gray_edge_rms_dn), um(p.fit_error_mm),
               um(p.fit_shift_mm), report::number(p.chain_s, 3), notes_of(p)},
              p.scheme.is_default ? "group" : "");
  return t.html();
}

const ParetoPoint* find(const ParetoResult& result, bool Scheme::*flag) {
  for (const ParetoPoint& p : result.points)
    if (p.scheme.*flag) return &p;
  return nullptr;
}

std::string summary(const ParetoResult& result) {
  const ParetoPoint *chosen = find(result, &Scheme::is_default),
                    *published = find(result, &Scheme::is_published);
  report::Table t;
  t.columns = {{"at a glance", "", Align::left}, {"frame", "ms"}, {"phase, interior", "rad rms"},
               {"gray, all", "DN rms"},          {"fit", "µm"},   {"chain", "s"}};
  for (const auto& [label, p] : {std::pair{"default", chosen}, std::pair{"published scheme", published}})
    if (p)
      t.add_row({fmt::format("{}: {}", label, p->name()), report::number(p->frame_ms, 3),
                 scientific(p->error.phase_interior_rms_rad), scientific(p->error.gray_rms_dn),
                 std::isfinite(p->fit_error_mm) ? report::number(1e3 * p->fit_error_mm, 2) : "–",
                 report::number(p->chain_s, 3)});
  std::string html = t.html();
  if (chosen && published)
    html += fmt::format("<p>The default takes {} of the published scheme's time{}.</p>",
                        "1/" + report::number(published->frame_ms / chosen->frame_ms, 3),
                        published->extrapolated_from > 0 ? " (extrapolated)" : "");
  return html;
}

std::string figures(const ParetoResult& result) {
  std::vector<Axes> axes{
      {"time of one camera's frame [ms]", "phase error, interior [rad rms]",
       [](const ParetoPoint& p) { return p.frame_ms; },
       [](const ParetoPoint& p) { return p.error.phase_interior_rms_rad; }, &ParetoPoint::on_phase_front},
      {"time of one camera's frame [ms]", "gray error, all pixels [DN rms]",
       [](const ParetoPoint& p) { return p.frame_ms; },
       [](const ParetoPoint& p) { return p.error.gray_rms_dn; }, &ParetoPoint::on_gray_front}};
  if (result.has_fits)
    axes.push_back({"render + sensor + measure [s]", "shift of the fit [mm]",
                    [](const ParetoPoint& p) { return p.chain_s; },
                    [](const ParetoPoint& p) { return p.fit_shift_mm; }, &ParetoPoint::on_fit_front});
  std::vector<Plot> plots;
  for (const Axes& a : axes) plots.push_back(error_plot(result, a));
  const auto svgs = report::plots_or_sentences(plots, "pareto");
  const std::vector<std::string> captions{
      "Phase error at the finest pitch over interior pixels against the time of one camera's frame with all "
      "its images. Numbers: samples per pixel (adaptive: the error aimed at); filled: single, open: double "
      "precision.",
      "Gray error over all pixels of the objects, silhouettes and borders of light included with their share "
      "in the image.",
      "The whole chain: how far the fitted quantities are from those of the most exact rendering in this "
      "run, as the sensor records the images (so not below what its rounding leaves). The table has the "
      "error against what was put in, too, which contains what the measuring method itself does."};
  const std::vector<std::string> formulas{
      "rms(arg(F_rendered · conj(F_reference)))", "rms(gain · (E_rendered - E_reference))",
      "max over objects of |place, size, rms: fitted - fitted to the most exact rendering|"};
  std::string out;
  for (std::size_t i = 0; i < svgs.size(); ++i) out += report::figure_html(svgs[i], captions[i], formulas[i]);
  return out;
}

}  // namespace

std::string pareto_html(const Twin& twin, const ParetoResult& result, const ParetoOptions& options,
                        const compare::Provenance& provenance) {
  report::Page page;
  page.title = "Speed against error: “" + twin.name + "”";
  page.subtitle = fmt::format("{} camera(s), {} images each, on {}{}", twin.cameras.size(),
                              expand_sequence(twin.fringes).size(), result.device.name,
                              options.quick ? ", quick selection of schemes" : "");
  page.summary_html = summary(result);
  page.note = fmt::format(
      "Errors against the double-precision reference ({0} x {0} Gauss points in interior pixels, {1} x {1} "
      "at facet edges, {2} x {2} at silhouettes, known there to {3} DN) over {4}.",
      options.reference.gauss_interior, options.reference.gauss_facet, options.reference.gauss_edge,
      report::number(result.reference_uncertainty_dn, 2), result.subset.text());
  page.warnings = result.warnings;
  page.sections = {{"plots", "Error against time", figures(result)}, {"table", "Every point", table(result)}};
  page.footer_html = provenance_html(twin, provenance, result.device);
  return page.html();
}

}  // namespace fringetwin::tradeoff
