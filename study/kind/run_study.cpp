// SPDX-License-Identifier: Apache-2.0
#include "study/kind/run_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "compare/run_page.hpp"
#include "report/plot/page_drawings.hpp"
#include "report/text.hpp"
#include "study/kind/check_study.hpp"
#include "study/kind/empty_columns.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostReasons = 5;
/// The table of a study that was stopped: study.csv is there only of one that is finished.
constexpr const char* kUnfinished = "unfinished.csv";
/// Its page, where it was asked for.
constexpr const char* kUnfinishedPage = compare::kUnfinishedStudyPage;

/// The last files of an earlier run go only once the folder is known to be of this study.
void take_away_last_files(const Kind& kind, const fs::path& out) {
  std::vector<std::string> files = {"report.html", "study.csv", kUnfinished, kUnfinishedPage};
  if (kind.has_result()) files.emplace_back("result.json");
  begin_output(out, files, Writers::several);
}

/// Says words of results: on stdout, unless that is for JSON alone.
void tell(const StudyRun& run, const std::string& words) {
  if (!run.json) return run.print(plain_lines(words));
  std::istringstream lines(words);
  for (std::string line; std::getline(lines, line);) say(line);
}

std::vector<StoredPoint> rows_so_far(const StudyStore& store) {
  std::vector<StoredPoint> rows = store.rows(0);
  std::erase_if(rows, [](const StoredPoint& row) { return row.status == PointStatus::pending; });
  return rows;
}

/// Says what the rows say, and writes them as a table.
void write_so_far(const Kind& kind, const std::vector<StoredPoint>& rows, const StudyRun& run) {
  tell(run, kind.tell_stopped(rows));
  write_text_file(run.out / kUnfinished, study_csv(rows));
  say("table so far: " + (run.out / kUnfinished).string());
}

/// Returns the command that shows a stopped study, made of the one that was typed.
std::string so_far_command(std::vector<std::string> argv) {
  std::erase(argv, "--figures");  // are drawn of a study that is finished
  argv.insert(std::ranges::find(argv, "--"), "--so-far");
  return report::shell_command(argv);
}

/// Shows what there is so far. A table that cannot be written is a warning: what was asked for is the end.
void show_unfinished(const Kind& kind, const StudyStore& store, const StudyRun& run) {
  try {
    const std::vector<StoredPoint> rows = rows_so_far(store);
    if (rows.empty()) return;
    write_so_far(kind, rows, run);
    say(fmt::format("`{}` {}", so_far_command(run.argv),
                    kind.has_page_so_far() ? "makes a page of that" : "shows that again"));
  } catch (const UserError& fault) {
    warn(fault.what());
  }
}

void run_until_stopped(Kind& kind, KeptPoints& points, const StudyStore& store, const StudyRun& run) {
  try {
    kind.run(points);
  } catch (const Cancelled&) {
    const auto counts = store.counts();
    const auto finished = static_cast<std::size_t>(counts.done + counts.failed);
    const auto all = kind.points_in_all();
    say(fmt::format("stopped {}; the same command goes on from there",
                    all ? fmt::format("with {} of {} finished", finished, points_text(*all))
                        : "after " + points_text(finished)));
    show_unfinished(kind, store, run);
    throw;
  }
}

std::string traces_text(const EngineSummary& summary) {
  return fmt::format("light traced for {} of {}: {} traces saved\n", summary.traced,
                     points_text(summary.finished), summary.finished - summary.traced);
}

/// Warns of the reasons of what failed, each once. Throws UserError(usage) when no point could be measured: a
/// study without a result is no success.
void warn_of_failures(const StudyRecord& study) {
  std::set<std::string> reasons;
  bool any_done = false;
  for (const StoredPoint& row : study.rows) {
    if (row.status == PointStatus::failed) reasons.insert(row.outcome.reason);
    any_done = any_done || row.status == PointStatus::done;
  }
  if (!any_done && !reasons.empty())
    throw UserError(ExitCode::usage, study.head.file.string(),
                    "no point could be measured: " + *reasons.begin());
  std::size_t told = 0;
  for (const std::string& reason : reasons) {
    if (++told > kMostReasons) break;
    warn("points failed: " + reason);
  }
}

void write_report(const StudyRun& run, const StudyReport& report) {
  if (run.figures) {
    std::vector<report::PageDrawing> drawings;
    for (const auto& [name, svg] : report.figures) drawings.push_back({name, svg});
    report::write_drawings(run.out / "figures", drawings);
  }
  write_text_file(run.out / "report.html", report.html);
  say("page: " + (run.out / "report.html").string());
}

}  // namespace

ExitCode run_study(Kind& kind, const StudyHead& head, const StudyRun& run) {
  const PointSequence planned = kind.plan();
  const StudyIdentity identity = check_study(head, planned);
  refuse_outside_noise_theory(head, planned);
  begin_output(run.out, {}, Writers::several);
  StudyStore store(run.out / "study.db", identity, run.version);
  if (const auto all = kind.points_in_all()) store.refuse_rows_from(static_cast<std::int64_t>(*all));
  kind.check(store);
  take_away_last_files(kind, run.out);
  KeptPoints points(kind.task(), run.engine, store);
  run_until_stopped(kind, points, store, run);

  const std::vector<StoredPoint> rows = store.finished_rows();
  const StudyRecord study{head, rows, identity, run.argv, run.version};
  const fs::path table = run.out / "study.csv", result = run.out / "result.json";
  write_text_file(table, study_csv(rows));
  const std::string json = kind.has_result() ? kind.write() : "";
  if (kind.has_result()) write_text_file(result, json);
  tell(run, kind.tell(study, points.summary()) + traces_text(points.summary()));
  warn_of_failures(study);
  for (const std::string& sentence : empty_column_warnings(head, rows)) warn(sentence);
  points.tell_later_gate_warnings();
  say(kind.has_result() ? "result: " + result.string() : "table: " + table.string());
  write_report(run, kind.report(study));
  begin_output(run.out, {kUnfinished, kUnfinishedPage}, Writers::several);  // --so-far, shown while it ran
  if (run.json) run.print(kind.has_result() ? json : study_table_json(rows));
  return kind.verdict();
}

ExitCode show_study_so_far(Kind& kind, const StudyHead& head, const StudyRun& run) {
  const fs::path database = run.out / "study.db";
  if (!fs::exists(database))
    throw UserError(ExitCode::usage, run.out.string(), "holds no study.db, so there is nothing to show",
                    "run the study first, without --so-far");
  const StudyIdentity identity = check_study(head, kind.plan());
  const StudyStore store(database, identity, run.version);
  if (fs::exists(run.out / "report.html")) {  // what a study writes last
    say("the study is finished: " + (run.out / "report.html").string());
    if (run.json) run.print(study_table_json(rows_so_far(store)));
    return ExitCode::ok;
  }
  const std::vector<StoredPoint> rows = rows_so_far(store);
  write_so_far(kind, rows, run);
  const StudyRecord study{head, rows, identity, run.argv, run.version};
  if (const std::optional<StudyReport> page = kind.report_so_far(study)) {
    write_text_file(run.out / kUnfinishedPage, page->html);
    say("page so far: " + (run.out / kUnfinishedPage).string());
  }
  if (run.json) run.print(study_table_json(rows));
  return ExitCode::ok;
}

}  // namespace fringetwin::study
