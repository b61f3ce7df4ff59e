// SPDX-License-Identifier: Apache-2.0
#include "compare/page/report_page.hpp"

#include <fmt/format.h>

#include <functional>

#include "compare/held_out/held_out.hpp"
#include "compare/page/answer.hpp"
#include "compare/page/field_table.hpp"
#include "compare/page/report_gain.hpp"
#include "compare/page/report_parts.hpp"
#include "compare/result/tables.hpp"
#include "compare/verdict/overall.hpp"
#include "report/cloud_canvas.hpp"
#include "report/html_page.hpp"
#include "report/provenance.hpp"
#include "report/table.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/parallel.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::compare {
namespace {

using report::Page;
using report::text_column;

/// Returns "0.50 µm rms (all points 0.61 µm)".
std::string residual_text(const measure::ObjectFit& fit) {
  std::string text = fmt::format("{} µm rms", report::fixed(1000.0 * fit.numbers.at("rms_mm"), 2));
  if (const auto all = fit.numbers.find("rms_all_mm"); all != fit.numbers.end())
    text += fmt::format(" (all points: {} µm)", report::fixed(1000.0 * all->second, 2));
  return text;
}

/// Tabulates the numbers a reader looks for first.
std::string glance_html(const Comparison& c) {
  report::Table table;
  table.columns = {text_column("at a glance"), {"value"}, {"n"}};
  for (const FitRow& row : c.fits) {
    if (row.simulated && row.simulated->usable && row.simulated->numbers.contains("rms_mm"))
      table.add_row({fmt::format("{}: residual of the simulated {} fit", row.object, row.kind),
                     residual_text(*row.simulated), points_text(row.simulated)});
    if (const auto at = row.difference_vectors.find("center_mm"); at != row.difference_vectors.end())
      table.add_row({row.object + ": distance of the centres, simulated − real",
                     report::fixed(1000.0 * at->second.norm(), 2) + " µm", ""});
    if (const auto at = row.difference.find("radius_mm"); at != row.difference.end())
      table.add_row({row.object + ": radius, simulated − real",
                     report::signed_fixed(1000.0 * at->second, 2) + " µm", ""});
  }
  for (const PhaseRow& r : c.phase)
    table.add_row({fmt::format("{} {}: phase difference", r.camera, r.direction),
                   fmt::format("{} rad rms, {} % relative mean", report::fixed(r.rms_rad, 4),
                               report::number(100.0 * r.mean_relative, 3)),
                   report::count(r.n)});
  for (const GainRow& r : c.gain)
    table.add_row(
        {fmt::format("{}: gray residual before → after the gain fit", r.camera),
         fmt::format("{} → {} DN rms", report::number(r.rms_before_dn, 3), report::number(r.rms_after_dn, 3)),
         report::count(r.n)});
  return table.rows.empty() ? "" : table.html();
}

std::string footer_html(const Twin& twin, const Provenance& p) {
  report::Facts facts{{"twin", twin.file.string()},
                      {"command", report::shell_command(p.argv)},
                      {"version", p.version},
                      {"device", p.device.empty() ? "nothing was rendered in this run" : p.device}};
  for (const RenderNote& n : p.rendered) facts.emplace_back("rendered “" + n.camera + "”", n.text());
  facts.emplace_back("seed", std::to_string(p.seed));
  return report::provenance_html(facts, p.inputs_sha256) +
         "<p>Every formula: docs/METRICS.md of the fringetwin source. All differences are simulated − "
         "real.</p>";
}

/// The sections of a page, made side by side: most of the time goes into plots, each a process of its own,
/// and into the compression of maps.
class Sections {
 public:
  void add(std::string id, std::string title, std::function<std::string()> body) {
    parts_.push_back({std::move(id), std::move(title), std::move(body)});
  }
  /// Puts those that are not empty on the page, in the order in which they were added, and shows how far it
  /// is.
  void put_on(Page& page) const {
    Progress progress("page", parts_.size());
    std::vector<std::string> bodies(parts_.size());
    for_each_parallel(static_cast<int>(parts_.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      bodies[k] = parts_[k].body();
      progress.advance();
    });
    for (std::size_t k = 0; k < parts_.size(); ++k)
      if (!bodies[k].empty()) page.sections.push_back({parts_[k].id, parts_[k].title, std::move(bodies[k])});
  }

 private:
  struct Part {
    std::string id, title;
    std::function<std::string()> body;
  };
  std::vector<Part> parts_;
};

/// Adds a section for every table of the result that says it is one.
void add_plain_tables(const Comparison& c, Sections& sections) {
  for (const Table& of : tables()) {
    if (of.heading.empty()) continue;
    sections.add(of.key, of.heading, [&of, &c]() -> std::string {
      const std::vector<const void*> rows = of.rows_of_comparison(c);
      if (rows.empty()) return "";
      report::Table table = field_table(of.fields(), rows);
      table.caption = of.caption;
      return table.html();
    });
  }
}

std::string subtitle(const Twin& twin, const ReportInput& in) {
  std::string cameras;
  for (const Camera& c : twin.cameras)
    cameras += fmt::format("{}“{}” {} × {} px{}", cameras.empty() ? "" : ", ", c.name, c.lens.width(),
                           c.lens.height(), c.channel ? " (" + text_of(*c.channel) + ")" : "");
  std::string held_out;  // of a real capture what says most about the twin
  for (const std::string& sentence : held_out_sentences(in.comparison.held_out)) held_out += sentence + " · ";
  return held_out + fmt::format("Simulated against {} measurement · {} · {} images each",
                                in.has_real_images() ? "real" : "published",
                                (twin.cameras.size() == 1 ? "camera " : "cameras ") + cameras,
                                expand_sequence(twin.fringes).size());
}

/// Returns what to do next, with the command to type.
std::string next_html(const ReportInput& in, const std::vector<std::string>& argv) {
  const NextStep next = next_step(in.comparison, in.twin, argv);
  if (next.text.empty()) return "";
  const std::string command =
      next.argv.empty() ? "" : ": <code>" + report::escape_html(report::shell_command(next.argv)) + "</code>";
  return next_paragraph(next.text, command);
}

}  // namespace

void write_report(const std::filesystem::path& dir, const Twin& twin, const Side& real, const Side& simulated,
                  const Comparison& comparison, const CompareOptions& options, const Provenance& provenance,
                  const std::map<std::string, double>& timing_s) {
  std::filesystem::create_directories(dir);
  const ReportInput in{
      dir, twin, real, simulated, comparison, options, report::shell_command(provenance.argv)};
  Page page;
  page.title = twin.name.empty() ? twin.file.stem().string() : twin.name;
  if (const std::string answer = answer_sentence(comparison); !answer.empty()) page.answer = answer + ".";
  page.subtitle = subtitle(twin, in);
  const OverallVerdict overall = overall_verdict(comparison);
  page.verdict = overall.text;
  page.verdict_class = overall.badge;
  page.summary_html = next_html(in, provenance.argv) + verdict_html(comparison) +
                      explained_summary_html(comparison) + glance_html(comparison);
  page.note = options.note;
  page.warnings = comparison.warnings;
  const Comparison& c = comparison;
  Sections sections;
  sections.add("refined", "Refined values", [&] { return refinement_html(c); });
  sections.add("causes", "What the budget does not explain",
               [&] { return causes_html(c) + pattern_html(c); });
  sections.add("coverage", "Coverage", [&] { return coverage_html(in); });
  sections.add("fits", "Fitted geometry", [&] { return fits_html(in) + indicators_html(c); });
  sections.add("gain", "Gain", [&] { return gain_table_html(c) + gain_checks_html(c); });
  sections.add("images", "Fringe images", [&] { return gray_figures_html(in); });
  sections.add("held_out_worst", "The held-out image predicted worst",
               [&] { return held_out_figures_html(in); });
  sections.add("budget", "What the gray residual is made of", [&] { return budget_html(c); });
  sections.add("noise", "Noise", [&] { return noise_html(in); });
  sections.add("shift", "Shift between the images", [&] { return shift_html(in); });
  sections.add("phase", "Phase",
               [&] { return phase_table_html(c) + phase_budget_html(c) + phase_figures_html(in); });
  sections.add("deviation", "Deviation from the fitted surface", [&] { return geometry_figures_html(in); });
  sections.add("explained", "Uncertainty budget", [&] { return explained_html(c); });
  add_plain_tables(c, sections);
  sections.add("timing", "Timing", [&] { return timing_html(timing_s); });
  sections.put_on(page);
  page.footer_html = footer_html(twin, provenance);
  page.script = report::cloud_script();
  write_text_file(dir / "report.html", page.html());
}

}  // namespace fringetwin::compare
