// SPDX-License-Identifier: Apache-2.0
// The page that a study ends with, one per kind (docs/METRICS.md, "Report of a study").
#pragma once
#include <string>
#include <vector>

#include "study/figure_sheet.hpp"
#include "study/monte_carlo_study.hpp"
#include "study/study_file.hpp"
#include "study/study_store.hpp"

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

}  // namespace fringetwin::study
