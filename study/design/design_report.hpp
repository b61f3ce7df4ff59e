// SPDX-License-Identifier: Apache-2.0
// Makes the page and the drawings of a design from its rows.
#pragma once
#include "study/design/design_plan.hpp"
#include "study/page/study_report.hpp"

namespace fringetwin::study {

/// Throws Cancelled.
StudyReport design_report(const StudyRecord& study, const DesignPlan& plan);

}  // namespace fringetwin::study
