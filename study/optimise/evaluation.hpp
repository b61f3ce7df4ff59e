// SPDX-License-Identifier: Apache-2.0
// What a study of kind "optimise" is asked for, and what the trials say of one setting of the rig.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "study/optimise/noisy_values.hpp"
#include "study/plan/study_tables.hpp"
#include "study/uncertain/uncertain_file.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::study {

inline constexpr const char* kTimeResult = "acquisition.time_s";  ///< what a setting costs

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

struct Evaluation {
  std::string phase;       ///< of the search
  Settings values;         ///< the chosen ones
  std::size_t failed = 0;  ///< trials without a measurement, or without one of the numbers
  std::string reason;      ///< of the first
  StatisticValue objective;
  std::vector<StatisticValue> constraints;  ///< means
  double time_s = 0.0;                      ///< of the acquisition; NaN: no camera says its exposure
  bool feasible = false;
  double theory = kNan;  ///< the objective in closed form
};

}  // namespace fringetwin::study
