// SPDX-License-Identifier: Apache-2.0
// What the page of every study is made from (docs/metrics/study.md, "Report of a study"): the study, its
// rows, and what wrote it.
#pragma once
#include <string>
#include <vector>

#include "study/page/figure_sheet.hpp"
#include "study/plan/study_head.hpp"
#include "study/store/study_store.hpp"

namespace fringetwin::study {

struct StudyRecord {
  const StudyHead& head;
  const std::vector<StoredPoint>& rows;
  const StudyIdentity& identity;
  std::vector<std::string> argv;  ///< the command as typed
  std::string version;            ///< of the program that writes the page
};

}  // namespace fringetwin::study
