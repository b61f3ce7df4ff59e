// SPDX-License-Identifier: Apache-2.0
// A Monte Carlo study on this machine: trials by worker processes, kept in the study's store.
#pragma once
#include "study/local_engine.hpp"
#include "study/monte_carlo_study.hpp"
#include "study/study_file.hpp"
#include "study/study_store.hpp"

namespace fringetwin::study {

/// The plan with the directions of the twin's calibration. Throws UserError where it cannot be read.
MonteCarloPlan complete_plan(const StudyFile& study);

/// The first trial as a point without its calibration, for check_study.
StudyPoint first_trial(const StudyFile& study);

/// Points that the store has finished are not run again: the same result after any interruption. Throws as
/// run_local does. `summary`: of all batches together.
MonteCarloResult run_monte_carlo_local(const StudyFile& study, const MonteCarloPlan& plan, StudyStore& store,
                                       const LocalOptions& options, LocalSummary* summary);

}  // namespace fringetwin::study
