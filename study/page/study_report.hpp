// SPDX-License-Identifier: Apache-2.0
// The page that a study ends with, one per kind (docs/METRICS.md, "Report of a study").
#pragma once
#include <string>
#include <vector>

#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/optimise/optimise.hpp"
#include "study/page/figure_sheet.hpp"
#include "study/store/study_store.hpp"
#include "study/study_file.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {

/// What every page needs of its study.
struct StudyRecord {
  const StudyFile& file;
  const std::vector<StoredPoint>& rows;
  const StudyIdentity& identity;
  std::vector<std::string> argv;  ///< the command as typed
  std::string version;            ///< of the program that writes the page
};

/// Throws Cancelled.
StudyReport design_report(const StudyRecord& study);
StudyReport monte_carlo_report(const StudyRecord& study, const MonteCarloPlan& plan,
                               const MonteCarloResult& result);
StudyReport optimise_report(const StudyRecord& study, const OptimisePlan& plan, const OptimiseResult& result);
StudyReport volume_map_report(const StudyRecord& study, const VolumeMapPlan& plan, const VolumeMap& map);

}  // namespace fringetwin::study
