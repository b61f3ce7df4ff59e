// SPDX-License-Identifier: Apache-2.0
// Makes the page and the drawings of a Monte Carlo study from its rows and its result.
#pragma once
#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/page/study_report.hpp"

namespace fringetwin::study {

/// Throws Cancelled.
StudyReport monte_carlo_report(const StudyRecord& study, const MonteCarloPlan& plan,
                               const MonteCarloResult& result);

}  // namespace fringetwin::study
