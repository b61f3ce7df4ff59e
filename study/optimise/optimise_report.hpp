// SPDX-License-Identifier: Apache-2.0
// Makes the page and the drawings of a search for the best settings from its rows and its result.
#pragma once
#include "study/optimise/optimise.hpp"
#include "study/page/study_report.hpp"

namespace fringetwin::study {

/// Throws Cancelled.
StudyReport optimise_report(const StudyRecord& study, const OptimisePlan& plan, const OptimiseResult& result);

}  // namespace fringetwin::study
