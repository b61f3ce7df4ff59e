// SPDX-License-Identifier: Apache-2.0
// A Monte Carlo study as its file says it.
#pragma once
#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/run/point_runner.hpp"
#include "study/study_file.hpp"

namespace fringetwin::study {

/// The plan with the directions of the twin's calibration. Throws UserError where it cannot be read.
MonteCarloPlan complete_plan(const StudyFile& study);

/// What its trials have in common.
PointTask monte_carlo_task(const StudyFile& study, const MonteCarloPlan& plan);

/// The first trial as a point without its calibration, for check_study.
StudyPoint first_trial(const StudyFile& study);

}  // namespace fringetwin::study
