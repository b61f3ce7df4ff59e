// SPDX-License-Identifier: Apache-2.0
// Makes the page and the drawings of a volume map from its rows and its result.
#pragma once
#include "study/page/study_report.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {

/// Throws Cancelled.
StudyReport volume_map_report(const StudyRecord& study, const VolumeMapPlan& plan, const VolumeMap& map);

}  // namespace fringetwin::study
