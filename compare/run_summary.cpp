// SPDX-License-Identifier: Apache-2.0
#include "compare/run_summary.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "compare/result_file.hpp"
#include "report/html_page.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kDeepest = 32;  ///< levels of folders: a loop of mounts has an end

double number_under(const json& row, const char* key) {
  const auto at = row.is_object() ? row.find(key) : row.end();
  return row.is_object() && at != row.end() && at->is_number() ? at->get<double>()
                                                               : std::numeric_limits<double>::quiet_NaN();
}

std::string text_under(const json& row, const char* key) {
  const auto at = row.is_object() ? row.find(key) : row.end();
  return row.is_object() && at != row.end() && at->is_string() ? at->get<std::string>() : "";
}

/// Returns the rows of a table of the result; none where it has no such table.
std::vector<json> rows_under(const json& result, const char* table) {
  const auto at = result.find(table);
  return at != result.end() && at->is_array() ? at->get<std::vector<json>>() : std::vector<json>{};
}

/// Returns the second word of the command line: "cosim".
std::string command_of(const json& result) {
  const auto provenance = result.find("provenance");
  if (provenance == result.end() || !provenance->is_object()) return "";
  const std::vector<json> argv = rows_under(*provenance, "argv");
  return argv.size() > 1 && argv[1].is_string() ? argv[1].get<std::string>() : "";
}

/// Returns rms over predicted rms of the held-out images (docs/metrics/gray.md, "Held-out images") of the
/// worst camera.
double worst_held_out(const json& result) {
  std::map<std::string, std::pair<double, double>>
      sums;  // of each camera: what is left, and what is predicted
  for (const json& row : rows_under(result, "held_out")) {
    const double n = number_under(row, "n"), left = number_under(row, "rms_dn"),
                 predicted = number_under(row, "predicted_dn");
    if (!(n > 0.0) || !std::isfinite(left) || !std::isfinite(predicted)) continue;
    auto& [sum_left, sum_predicted] = sums[text_under(row, "camera")];
    sum_left += n * left * left;
    sum_predicted += n * predicted * predicted;
  }
  double worst = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [camera, sum] : sums)
    if (sum.second > 0.0) worst = std::fmax(worst, std::sqrt(sum.first / sum.second));
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

/// Returns the run that a folder holds; nothing where it holds none.
std::optional<RunSummary> run_in(const fs::path& folder) {
  std::error_code none;  // what cannot be looked at is not there
  const fs::path result = folder / "result.json", page = folder / "report.html";
  const bool has_result = fs::exists(result, none), is_study = fs::exists(folder / "study.db", none);
  RunSummary run;
  if (is_study)
    run.command = "study";  // whose result.json is of another kind
  else if (has_result)
    read_result(result, run);
  run.has_page = fs::exists(page, none) && read_page(page, run);
  if (!run.has_page && (is_study || !has_result)) return {};
  run.written = time_of(has_result && !is_study ? result : page);
  return run;
}

void look_below(const fs::path& dir, const fs::path& at, int depth, std::vector<RunSummary>& runs) {
  throw_if_cancelled();
  if (std::optional<RunSummary> run = run_in(dir / at)) {
    run->folder = at;
    runs.push_back(std::move(*run));
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
