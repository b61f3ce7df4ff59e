// SPDX-License-Identifier: Apache-2.0
// Turns the rows of a finished design into what its report shows: what varies, settings, numbers with their
// truth.
#pragma once
#include <string>
#include <vector>

#include "study/design/design_plan.hpp"
#include "study/page/varied_axes.hpp"
#include "study/plan/study_head.hpp"
#include "study/statistics/study_statistics.hpp"
#include "study/store/study_store.hpp"

namespace fringetwin::study {

/// A recorded number.
struct TableNumber {
  std::string name, unit;         ///< name: as it is shown
  bool is_error = false;          ///< the values are measured - put in
  bool is_time = false;           ///< acquisition.time_s
  bool is_measured = true;        ///< false: no noise can change it, it is of the theory or the acquisition
  std::vector<SettingRuns> runs;  ///< per setting, as they are drawn
  std::vector<double> truth;      ///< per setting what was put in; empty unless is_error
  /// What is expected, per setting; empty where nothing is, NaN where it is not known.
  std::vector<double> expected_mean, expected_sigma;
  GroupStatistics all;
  bool has_scatter() const { return all.sigma > 0.0; }
  double change = 0.0;  ///< variance between the settings' means over that of their noise, 0 … 1 without an
                        ///< effect; NaN: unknown
};

struct DesignTable : VariedSettings {
  bool scattered = false;            ///< values drawn, not listed: nearly every setting has its own
  std::size_t seeds = 1;             ///< runs of a setting when none fails
  std::vector<TableNumber> numbers;  ///< in the order of the file; without [[record]] those that change first
};

/// Makes the table. Rows whose points have not finished, or failed, leave gaps. Truths are the twin's own
/// values where a record is the centre or radius of a fit.
DesignTable design_table(const StudyHead& head, const DesignPlan& plan, const std::vector<StoredPoint>& rows,
                         double coverage);

}  // namespace fringetwin::study
