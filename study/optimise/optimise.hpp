// SPDX-License-Identifier: Apache-2.0
// Runs a study of kind "optimise": searches the settings of the rig, known to it, that make a number's
// uncertainty least under constraints (docs/metrics/study.md, "Optimise"). Who runs the points, and where
// they are kept, is the caller's.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "study/kind/kind.hpp"
#include "study/optimise/evaluation.hpp"
#include "study/optimise/foreknowledge.hpp"
#include "study/optimise/noisy_values.hpp"
#include "study/plan/study_tables.hpp"
#include "study/uncertain/uncertain_file.hpp"

namespace fringetwin::study {

/// The best of the search that are measured again, and by how many times its trials.
inline constexpr std::size_t kMostCandidates = 5, kMostRounds = 2, kFreshTrials = 4;

/// One of the best of the search, measured again with draws that no choice has seen.
struct Candidate {
  std::size_t evaluation = 0;
  Evaluation fresh;
  bool told_apart = false;  ///< it is surely worse than the chosen one
};

struct OptimiseResult {
  std::vector<Evaluation> evaluations;
  std::size_t screened = 0;                ///< settings whose objective was worked out in closed form
  std::size_t left_out = 0;                ///< settings that are no valid twin: none was measured
  std::string left_out_reason;             ///< of the first
  std::vector<Candidate> candidates;       ///< best of the search first
  std::optional<std::size_t> best;         ///< the feasible candidate with the least fresh objective
  std::optional<Evaluation> chosen;        ///< the best one once more: its value has chosen nothing
  std::optional<std::size_t> recommended;  ///< quickest of the best one and those not told apart from it
  /// Feasible ones that beat every quicker one surely, by rising time.
  std::vector<std::size_t> front;

  /// Returns what is known best of an evaluation: from the third set, the fresh trials, or the search.
  const Evaluation& last_of(std::size_t evaluation) const;
  /// Returns true where the constraints were met in the search and, if it was measured, again.
  bool is_feasible(std::size_t evaluation) const;
  /// Returns the feasible candidates that may be as good as the best one.
  std::vector<std::size_t> not_told_apart() const;
};

/// Returns which numbers of each measurement are needed, by their paths.
std::vector<Record> optimise_records(const OptimisePlan& plan);

/// Returns points of the twin itself, and with each value of a list alone and each range's ends, for
/// check_study.
std::vector<StudyPoint> optimise_samples(const OptimisePlan& plan);

/// Searches by `run`. Evaluation e has the points e * trials ..., with the same draws as any other's: what is
/// kept is not repeated, and found again in the same order. An evaluation of which a trial fails has failed.
/// The best are measured again with other draws, and the best of these once more; their points come after
/// all those of the search.
OptimiseResult run_optimise(const OptimisePlan& plan, const RunPoints& run, const Foreknowledge& known = {});

/// Returns result.json, "fringetwin-optimise/1".
std::string optimise_json(const OptimisePlan& plan, const OptimiseResult& result);

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> optimise_keys();

/// Reads the plan of a STUDY.toml. Throws UserError(usage) with file, line and key.
OptimisePlan read_optimise(const TomlTable& root, const std::filesystem::path& twin);

/// Returns what runs the study; the head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const OptimisePlan& plan);

/// Returns the page and its drawings. Throws Cancelled.
StudyReport optimise_report(const StudyRecord& study, const OptimisePlan& plan, const OptimiseResult& result);

}  // namespace fringetwin::study
