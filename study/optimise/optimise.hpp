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
#include "study/optimise/budgeted_search.hpp"
#include "study/plan/study_tables.hpp"
#include "study/uncertain/uncertain_file.hpp"

namespace fringetwin::study {

enum class Statistic { sigma, mean, rms_error };

struct Constraint {
  std::string result;
  std::optional<double> min, max;  ///< of the mean over the trials
};

struct OptimisePlan : UncertainSettings {
  std::vector<Variation> choose;
  std::string result;  ///< the number whose statistic is to be least
  Statistic statistic = Statistic::sigma;
  double value = 0.0;  ///< of rms_error: the true one
  std::vector<Constraint> constraints;
  std::size_t evaluations = 60, trials = 8;
  std::filesystem::path twin;
  std::uint64_t seed = 1;
};

/// A statistic with its standard error.
struct StatisticValue {
  double value = 0.0, sigma = 0.0;
};
/// Returns the statistic of the trials. The standard error of sigma is that of normal deviates,
/// sigma / sqrt(2 n - 2). NaN of less than two values, or with a NaN.
StatisticValue statistic_of(const std::vector<double>& trials, Statistic statistic, double value = 0.0);

struct Evaluation {
  std::string phase;       ///< of the search
  Settings values;         ///< the chosen ones
  std::size_t failed = 0;  ///< trials without a measurement, or without one of the numbers
  std::string reason;      ///< of the first
  StatisticValue objective;
  std::vector<StatisticValue> constraints;  ///< means
  double time_s = 0.0;                      ///< of the acquisition; NaN: no camera says its exposure
  bool feasible = false;
};

struct OptimiseResult {
  std::vector<Evaluation> evaluations;
  std::optional<std::size_t> best;
  /// Feasible ones that no other beats in both time and objective, by rising time.
  std::vector<std::size_t> front;
};

/// Returns which numbers of each measurement are needed, by their paths.
std::vector<Record> optimise_records(const OptimisePlan& plan);

/// Returns points of the twin itself, and with each value of a list alone and each range's ends, for
/// check_study.
std::vector<StudyPoint> optimise_samples(const OptimisePlan& plan);

/// Searches by `run`. Evaluation e has the points e * trials ..., with the same draws as any other's: what is
/// kept is not repeated, and found again in the same order. An evaluation of which a trial fails has failed.
OptimiseResult run_optimise(const OptimisePlan& plan, const RunPoints& run);

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
