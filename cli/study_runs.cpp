// SPDX-License-Identifier: Apache-2.0
#include "cli/study_runs.hpp"

#include <fmt/format.h>

#include <set>

#include "cli/version.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::cli {
namespace {

constexpr std::size_t most_reasons = 5;

/// What an earlier run drew.
std::vector<std::string> drawings_in(const std::filesystem::path& dir) {
  std::vector<std::string> out;
  std::error_code error;  // no folder: nothing
  for (const auto& entry : std::filesystem::directory_iterator(dir, error))
    if (entry.path().extension() == ".svg" && !entry.is_directory())
      out.push_back(entry.path().filename().string());
  return out;
}

}  // namespace

std::string points_text(std::int64_t n) { return fmt::format("{} point{}", n, n == 1 ? "" : "s"); }

std::unique_ptr<study::StudyStore> open_store(const StudyRun& run, const study::StudyIdentity& identity,
                                              const std::vector<std::string>& last_files) {
  begin_output(run.out, {});
  auto store = std::make_unique<study::StudyStore>(run.out / "study.db", identity, version_string());
  begin_output(run.out, last_files);
  return store;
}

void write_report(const StudyRun& run, const study::StudyReport& report) {
  if (run.figures) {
    begin_output(run.out / "figures", drawings_in(run.out / "figures"));
    for (const auto& [name, svg] : report.figures)
      write_text_file(run.out / "figures" / (name + ".svg"), svg);
    say(fmt::format("{} drawings: {}", report.figures.size(), (run.out / "figures").string()));
  }
  write_text_file(run.out / "report.html", report.html);
  say("page: " + (run.out / "report.html").string());
}

void tell_traces(const study::EngineSummary& summary) {
  fmt::print("light traced for {} of {}: {} traces saved\n", summary.traced,
             points_text(static_cast<std::int64_t>(summary.finished)), summary.finished - summary.traced);
}

void tell_stop(const study::StudyStore& store) {
  const auto counts = store.counts();
  say(fmt::format("stopped after {}; the same command goes on from there",
                  points_text(counts.done + counts.failed)));
}

void tell_failures(const std::filesystem::path& file, const std::vector<study::StoredPoint>& rows) {
  std::set<std::string> reasons;
  bool any_done = false;
  for (const study::StoredPoint& row : rows) {
    if (row.status == study::PointStatus::failed) reasons.insert(row.outcome.reason);
    any_done = any_done || row.status == study::PointStatus::done;
  }
  if (!any_done && !reasons.empty())
    throw UserError(ExitCode::usage, file.string(), "no point could be measured: " + *reasons.begin());
  std::size_t told = 0;
  for (const std::string& reason : reasons) {
    if (++told > most_reasons) break;
    warn("points failed: " + reason);
  }
}

}  // namespace fringetwin::cli
