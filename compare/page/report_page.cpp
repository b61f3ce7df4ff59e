// SPDX-License-Identifier: Apache-2.0
#include "compare/page/report_page.hpp"

#include <fmt/format.h>

#include "compare/held_out/held_out.hpp"
#include "compare/page/answer.hpp"
#include "compare/page/field_table.hpp"
#include "compare/page/report_gain.hpp"
#include "compare/page/report_parts.hpp"
#include "compare/result/milestones.hpp"
#include "compare/result/tables.hpp"
#include "compare/verdict/overall.hpp"
#include "report/cloud_canvas.hpp"
#include "report/html_page.hpp"
#include "report/provenance.hpp"
#include "report/table.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
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

constexpr std::size_t kSections = 14;  ///< that take their time, each with plots or maps

/// Adds sections to a page, and shows how far it is.
class Sections {
 public:
  explicit Sections(Page& page) : page_(page) {}
  void add(const std::string& id, const std::string& title, const std::string& body) {
    if (!body.empty()) page_.sections.push_back({id, title, body});
    progress_.step();
  }
  /// Adds a section for every table of the result that says it is one.
  void add_plain_tables(const Comparison& c) {
    for (const Table& of : tables()) {
      const std::vector<const void*> rows =
          of.heading.empty() ? std::vector<const void*>{} : of.rows_of_comparison(c);
      if (rows.empty()) continue;
      report::Table table = field_table(of.fields(), rows);
      table.caption = of.caption;
      page_.sections.push_back({of.key, of.heading, table.html()});
    }
  }

 private:
  Page& page_;
  Milestones progress_{"page", kSections};
};

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
  Sections sections(page);
  sections.add("refined", "Refined values", refinement_html(comparison));
  sections.add("causes", "What the budget does not explain",
               causes_html(comparison) + pattern_html(comparison));
  sections.add("coverage", "Coverage", coverage_html(in));
  sections.add("fits", "Fitted geometry", fits_html(in) + indicators_html(comparison));
  sections.add("gain", "Gain", gain_table_html(comparison) + gain_checks_html(comparison));
  sections.add("images", "Fringe images", gray_figures_html(in));
  sections.add("held_out_worst", "The held-out image predicted worst", held_out_figures_html(in));
  sections.add("budget", "What the gray residual is made of", budget_html(comparison));
  sections.add("noise", "Noise", noise_html(in));
  sections.add("shift", "Shift between the images", shift_html(in));
  const std::string phase_table = phase_table_html(comparison);
  sections.add("phase", "Phase", phase_table + phase_budget_html(comparison) + phase_figures_html(in));
  sections.add("deviation", "Deviation from the fitted surface", geometry_figures_html(in));
  sections.add("explained", "Uncertainty budget", explained_html(comparison));
  sections.add_plain_tables(comparison);
  sections.add("timing", "Timing", timing_html(timing_s));
  page.footer_html = footer_html(twin, provenance);
  page.script = report::cloud_script();
  write_text_file(dir / "report.html", page.html());
}

}  // namespace fringetwin::compare
