// SPDX-License-Identifier: Apache-2.0
#include "compare/run_summary.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "compare/held_out/held_out.hpp"
#include "compare/result_file.hpp"
#include "compare/run_page.hpp"
#include "report/html_page.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kDeepest = 32;  ///< levels of folders: a loop of mounts has an end

/// Returns what stands under a key; null where nothing does, and where the value is no table.
json value_under(const json& value, const char* key) {
  const auto at = value.is_object() ? value.find(key) : value.end();
  return value.is_object() && at != value.end() ? *at : json(nullptr);
}

double number_under(const json& row, const char* key) {
  const json value = value_under(row, key);
  return value.is_number() ? value.get<double>() : kNaN;
}

std::string text_under(const json& row, const char* key) {
  const json value = value_under(row, key);
  return value.is_string() ? value.get<std::string>() : "";
}

/// Returns the rows of a table of the result; none where it has no such table.
std::vector<json> rows_under(const json& result, const char* table) {
  const json value = value_under(result, table);
  return value.is_array() ? value.get<std::vector<json>>() : std::vector<json>{};
}

/// Returns the second word of the command line: "cosim".
std::string command_of(const json& result) {
  const std::vector<json> argv = rows_under(value_under(result, "provenance"), "argv");
  return argv.size() > 1 && argv[1].is_string() ? argv[1].get<std::string>() : "";
}

/// Returns the held-out ratio of the worst camera.
double worst_held_out(const json& result) {
  std::vector<HeldOutRow> rows;
  for (const json& row : rows_under(result, "held_out")) {
    const double n = number_under(row, "n");
    HeldOutRow& known = rows.emplace_back();
    known.camera = text_under(row, "camera");
    known.rms_dn = number_under(row, "rms_dn"), known.predicted_dn = number_under(row, "predicted_dn");
    if (n > 0.0 && std::isfinite(known.rms_dn) && std::isfinite(known.predicted_dn))
      known.n = static_cast<decltype(known.n)>(n);  // others count for nothing
  }
  double worst = kNaN;
  for (const HeldOutRow& row : rows) worst = std::fmax(worst, held_out_ratio(rows, row.camera));
  return worst;
}

void read_result(const fs::path& file, RunSummary& run) {
  try {
    const json result = read_result_file(file).json;
    run.twin = text_under(result, "twin");
    run.command = command_of(result);
    run.held_out_ratio = worst_held_out(result);
    for (const json& row : rows_under(result, "phase"))
      run.phase_rms_rad = std::fmax(run.phase_rms_rad, number_under(row, "rms_rad"));
    for (const json& row : rows_under(result, "gain"))
      if (const double gain = number_under(row, "gain_dn"); std::isfinite(gain))
        run.gains_dn.emplace_back(gain, number_under(row, "gain_sigma_dn"));
  } catch (const UserError& fault) {
    run.fault = fault.what();
  }
}

/// Returns whether a file is a page of this program; what its head says goes to `run`.
bool read_page(const fs::path& file, RunSummary& run) {
  const std::optional<report::PageHead> says = report::head_of_page(file);
  if (!says) return false;
  run.answer = says->answer;
  run.verdict = says->verdict;
  if (run.twin.empty()) run.twin = says->title;
  return true;
}

std::chrono::system_clock::time_point time_of(const fs::path& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 ? std::chrono::system_clock::from_time_t(status.st_mtime)
                                            : std::chrono::system_clock::time_point{};
}

/// Returns the run that a folder holds, with its report or what there is of one; nothing where it holds none.
std::optional<RunSummary> run_in(const fs::path& folder) {
  std::error_code none;  // what cannot be looked at is not there
  const fs::path result = folder / "result.json";
  const bool has_result = fs::exists(result, none), is_study = is_study_folder(folder);
  RunSummary run;
  if (is_study)
    run.command = "study";
  else if (has_result)
    read_result(result, run);
  if (read_page(folder / kRunPage, run)) {
    run.page = kRunPage;
  } else if (is_study) {
    run.answer = "The study is not finished.";
    if (RunSummary unfinished; read_page(folder / kUnfinishedStudyPage, unfinished)) {
      run.page = kUnfinishedStudyPage;
      run.twin = unfinished.twin;  // its verdict is none yet
    }
  }
  if (run.page.empty() && !is_study && !has_result) return {};
  run.written =
      time_of(has_result && !is_study ? result : folder / (run.page.empty() ? "study.db" : run.page));
  return run;
}

/// Returns the runs whose pages have names of their own: what they are about stands in their titles.
std::vector<RunSummary> own_pages_in(const fs::path& folder) {
  std::vector<RunSummary> runs;
  for (const OwnPage& page : kOwnPages) {
    RunSummary run;
    if (!read_page(folder / page.name, run)) continue;
    if (run.answer.empty()) run.answer = std::exchange(run.twin, "");
    run.command = page.command;
    run.page = page.name;
    run.written = time_of(folder / page.name);
    runs.push_back(std::move(run));
  }
  return runs;
}

void look_below(const fs::path& dir, const fs::path& at, int depth, std::vector<RunSummary>& runs) {
  throw_if_cancelled();
  std::vector<RunSummary> here = own_pages_in(dir / at);
  if (std::optional<RunSummary> run = run_in(dir / at)) here.insert(here.begin(), std::move(*run));
  for (RunSummary& run : here) {
    run.folder = at;
    runs.push_back(std::move(run));
  }
  if (depth == kDeepest) return;
  std::error_code error;  // a folder that cannot be read has no runs to show
  std::vector<fs::path> folders;
  for (fs::directory_iterator entry(dir / at, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code none;
    const fs::path name = entry->path().filename();
    if (!entry->is_symlink(none) && entry->is_directory(none) && !name.string().starts_with('.'))
      folders.push_back(at == "." ? name : at / name);
  }
  std::ranges::sort(folders);
  for (const fs::path& folder : folders) look_below(dir, folder, depth + 1, runs);
}

}  // namespace

std::vector<RunSummary> runs_below(const fs::path& dir) {
  std::vector<RunSummary> runs;
  look_below(dir, ".", 0, runs);
  return runs;
}

}  // namespace fringetwin::compare
