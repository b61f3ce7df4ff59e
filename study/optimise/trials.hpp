// SPDX-License-Identifier: Apache-2.0
// Measures settings of the rig in trials: settings go in, and what the trials say of each comes out; internal
// to study/optimise.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "study/optimise/budgeted_search.hpp"
#include "study/optimise/evaluation.hpp"
#include "study/plan/study_point.hpp"

namespace fringetwin::study {

/// Which draws all settings have, and the id of the first point; the others follow, trials fastest.
struct TrialBlock {
  std::int64_t first_id = 0;
  std::size_t first_trial = 0, trials = 0;
};

/// Returns an evaluation per setting, in their order. One of which a trial fails has failed.
std::vector<Evaluation> evaluate(const OptimisePlan& plan, const RunPoints& run,
                                 const std::vector<Settings>& values, const TrialBlock& block);

/// Returns objective and constraints as the search takes them; NaN of a failed evaluation.
Assessment assessment_of(const OptimisePlan& plan, const Evaluation& evaluation);

/// Returns the results that must be numbers in every trial.
std::vector<std::string> needed_results(const OptimisePlan& plan);

}  // namespace fringetwin::study
