// SPDX-License-Identifier: Apache-2.0
// The kinds of studies as `fringetwin study` runs them; internal to cli/.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "study/engine/engine.hpp"
#include "study/page/study_report.hpp"
#include "study/store/study_store.hpp"
#include "study/study_file.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cli {

struct StudyRun {
  study::StudyFile file;
  std::filesystem::path out;
  study::Engine* engine = nullptr;
  std::vector<std::string> argv;
  bool figures = false;  ///< the report's drawings as files, too
};

// One per kind; each returns the exit code.
int run_design(const StudyRun& run);
int run_monte_carlo(const StudyRun& run);
int run_volume_map(const StudyRun& run);
int run_optimise(const StudyRun& run);

/// "1 point", "12 points".
std::string points_text(std::int64_t n);

/// DIR/study.db. The last files of an earlier run beside it go only once it is known to be of this study.
std::unique_ptr<study::StudyStore> open_store(const StudyRun& run, const study::StudyIdentity& identity,
                                              const std::vector<std::string>& last_files);

/// "light traced for 2 of 14 points: 12 traces saved"
void tell_traces(const study::EngineSummary& summary);

/// DIR/report.html and, where asked for, DIR/figures/*.svg.
void write_report(const StudyRun& run, const study::StudyReport& report);

/// "stopped after 12 points; the same command goes on from there".
void tell_stop(const study::StudyStore& store);
/// Runs what adds to the store; after Ctrl-C it says how far that came and throws Cancelled on.
template <class Work>
auto run_until_stopped(const study::StudyStore& store, Work work) {
  try {
    return work();
  } catch (const fringetwin::Cancelled&) {
    tell_stop(store);
    throw;
  }
}

/// The reasons of what failed, each once. Throws UserError(usage) when no point could be measured: a study
/// without a result is no success.
void tell_failures(const std::filesystem::path& file, const std::vector<study::StoredPoint>& rows);

}  // namespace fringetwin::cli
