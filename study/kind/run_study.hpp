// SPDX-License-Identifier: Apache-2.0
// Walks a study of any kind from its plan to its report: checks it, opens its store, runs what is missing,
// and writes study.csv, result.json, report.html and, where asked for, the drawings.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "study/kind/kind.hpp"

namespace fringetwin::study {

struct StudyRun {
  std::filesystem::path out;
  Engine& engine;
  std::vector<std::string> argv;                  ///< the command as typed
  std::string version;                            ///< of this program
  bool figures = false;                           ///< the report's drawings as files, too
  std::function<void(const std::string&)> print;  ///< takes what is said on stdout, in whole lines
  bool json = false;  ///< stdout is the result as JSON and nothing else: words go to stderr
};

/// Returns the exit code. A study that was run before goes on where it stopped. Throws UserError; Cancelled
/// after Ctrl-C, with what is finished in the store.
ExitCode run_study(Kind& kind, const StudyHead& head, const StudyRun& run);

/// Runs nothing: says what the points say that have finished, and writes them as unfinished.csv and, of kinds
/// that have such a page, unfinished.html. The study may be running meanwhile. Throws UserError(usage) where
/// there is no such study; Cancelled.
ExitCode show_study_so_far(Kind& kind, const StudyHead& head, const StudyRun& run);

}  // namespace fringetwin::study
