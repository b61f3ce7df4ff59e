// SPDX-License-Identifier: Apache-2.0
// Runs a study of kind "monte-carlo": trials until the numbers are known well enough, then the points that
// say which input the spread comes from. Who runs the points, and where they are kept, is the caller's.
#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "study/kind/kind.hpp"
#include "study/statistics/monte_carlo.hpp"
#include "study/statistics/sobol_indices.hpp"
#include "study/uncertain/uncertain_file.hpp"

namespace fringetwin::study {

/// Behind every possible trial, so that more trials may be asked for later.
inline constexpr std::int64_t kFirstRowId = kMostPoints;

struct MonteCarloPlan : UncertainSettings {
  AdaptiveRule rule;
  std::uint64_t seed = 1;
  std::size_t most_trials = 10'000;  ///< trials are ids 0 ... most_trials - 1
  /// 0: no indices; each row costs 1 + number of factors measurements, whose ids begin at kFirstRowId.
  std::size_t sensitivity_rows = 0;
};

struct MonteCarloNumber {
  SampleSummary summary;
  Convergence convergence;
  SobolIndices sensitivity;  ///< order of MonteCarloResult::factors; empty without rows
};

struct MonteCarloResult {
  std::size_t trials = 0, failed = 0;
  bool converged = false;  ///< all numbers
  std::vector<std::string> factors;
  std::map<std::string, MonteCarloNumber> numbers;
};

/// Returns how many trials all numbers will need, going by those that there are; nothing where that cannot be
/// told yet.
std::optional<std::size_t> trials_foreseen(const MonteCarloResult& result);

/// Runs the trials by `run`, and calls `after_block` with what is known after each block. Ids are those of
/// the plan whatever was run before: a caller that keeps outcomes repeats none. The rows of the sensitivity
/// take the first trials as their first sample.
MonteCarloResult run_monte_carlo(const MonteCarloPlan& plan, const RunPoints& run,
                                 const std::function<void(const MonteCarloResult&)>& after_block = {});

/// Returns what the trials say that have finished, of a study that was stopped: without sensitivities.
MonteCarloResult monte_carlo_so_far(const MonteCarloPlan& plan, const std::vector<StoredPoint>& rows);

/// Returns result.json: {"trials", "failed", "converged", "numbers": [{"name", "n", "mean", "sigma",
/// "symmetric", "shortest",
/// ...}]}
std::string monte_carlo_json(const MonteCarloPlan& plan, const MonteCarloResult& result);

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> monte_carlo_keys();

/// Reads the plan of a STUDY.toml. Middles of distributions are the twin's own values where [[uncertain]] has
/// no `value`. Throws UserError(usage) with file, line and key.
MonteCarloPlan read_monte_carlo(const TomlTable& root, const std::filesystem::path& twin);

/// Returns what runs the study; the head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const MonteCarloPlan& plan);

/// Returns the page and its drawings. Throws Cancelled.
StudyReport monte_carlo_report(const StudyRecord& study, const MonteCarloPlan& plan,
                               const MonteCarloResult& result);

}  // namespace fringetwin::study
