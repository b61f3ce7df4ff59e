// SPDX-License-Identifier: Apache-2.0
#include "compare/run_index.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "report/html_page.hpp"
#include "report/provenance.hpp"
#include "report/table.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

constexpr const char* kTitle = "Runs of fringetwin";

/// Returns the gains of all cameras: "17.3029 ± 0.0041, 18.10 ± 0.12".
std::string gains_text(const RunSummary& run) {
  std::string text;
  for (const auto& [gain, sigma] : run.gains_dn)
    text += (text.empty() ? "" : ", ") + report::with_sigma(gain, sigma);
  return text;
}

/// Returns what was found, in words: the page's first sentence, or why there is none.
std::string words_of(const RunSummary& run) {
  if (!run.fault.empty()) return run.fault;
  if (!run.answer.empty()) return run.answer;
  return !run.page.empty() ? "" : "no page: the run has not ended, or its page was removed";
}

std::string date_of(const RunSummary& run) {
  return fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(std::chrono::system_clock::to_time_t(run.written)));
}

std::string optional_number(double value, int decimals) {
  return std::isfinite(value) ? report::fixed(value, decimals) : "";
}

report::Table table_of(const std::vector<RunSummary>& runs) {
  report::Table table;
  table.cards = true;
  table.caption =
      "Held out: rms over predicted noise of images that took no part in a fit. Phase: rms of simulated − "
      "real. "
      "Both of the worst camera.";
  table.columns = {report::text_column("run"),
                   report::text_column("written"),
                   report::text_column("twin"),
                   report::text_column("command"),
                   report::text_column("verdict"),
                   report::text_column("answer"),
                   {"held out"},
                   {"phase", "rad"},
                   {"gain", "DN"}};
  for (const RunSummary& run : runs) {
    table.add_row(
        {run.folder.string(), date_of(run), run.twin, run.command, run.verdict, words_of(run),
         optional_number(run.held_out_ratio, 3), optional_number(run.phase_rms_rad, 5), gains_text(run)},
        run.fault.empty() ? "" : "fault");
    if (!run.page.empty())
      table.rows.back().link = report::url_path((run.folder / run.page).lexically_normal().string());
  }
  return table;
}

}  // namespace

std::string run_index_html(const std::filesystem::path& dir, const std::vector<RunSummary>& runs,
                           const std::vector<std::string>& argv, const std::string& version) {
  report::Page page;
  page.title = kTitle;
  page.subtitle = dir.string();
  page.answer = runs.empty()       ? "No run is here."
                : runs.size() == 1 ? "1 run."
                                   : fmt::format("{} runs.", runs.size());
  if (!runs.empty()) page.sections.push_back({"runs", "Runs", table_of(runs).html()});
  page.footer_html =
      report::provenance_html({{"command", report::shell_command(argv)}, {"version", version}}) +
      "<p>The same command lists them anew.</p>";
  return page.html();
}

bool is_run_index(const std::filesystem::path& file) {
  const std::optional<report::PageHead> says = report::head_of_page(file);
  return says && says->title == kTitle;
}

}  // namespace fringetwin::compare
