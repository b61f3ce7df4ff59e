// SPDX-License-Identifier: Apache-2.0
// The rows of a finished design as its report looks at them: what varies, settings, numbers with their truth.
#pragma once
#include <string>
#include <vector>

#include "study/statistics/study_statistics.hpp"
#include "study/store/study_store.hpp"
#include "study/study_file.hpp"

namespace fringetwin::study {

/// What is varied together: one [[vary]], or all of a list.
struct VariedAxis {
  std::string label;  ///< the keys, what differs between them as *
  std::string brief;  ///< their last part
  bool numeric = false, log = false;
  std::vector<double> values;      ///< of the levels: the number, or 0, 1 ...
  std::vector<std::string> names;  ///< of the levels
};

struct Setting {
  std::vector<std::size_t> level;  ///< per axis
};

/// A recorded number.
struct TableNumber {
  std::string name, unit;         ///< name: as it is shown
  bool is_error = false;          ///< the values are measured - put in
  bool is_time = false;           ///< acquisition.time_s
  std::vector<SettingRuns> runs;  ///< per setting, as they are drawn
  std::vector<double> truth;      ///< per setting what was put in; empty unless is_error
  /// What is expected, per setting; empty where nothing is, NaN where it is not known.
  std::vector<double> expected_mean, expected_sigma;
  GroupStatistics all;
  bool has_scatter() const { return all.sigma > 0.0; }
  double change = 0.0;  ///< variance between the settings' means over that of their noise, 0 … 1 without an
                        ///< effect; NaN: unknown
};

struct DesignTable {
  std::vector<VariedAxis> axes;   ///< with two levels or more
  std::vector<VariedAxis> fixed;  ///< with one
  bool scattered = false;         ///< values drawn, not listed: nearly every setting has its own
  std::size_t seeds = 1;          ///< runs of a setting when none fails
  std::vector<Setting> settings;
  std::vector<TableNumber> numbers;  ///< in the order of the file; without [[record]] those that change first
};

/// Rows whose points have not finished, or failed, leave gaps. Truths are the twin's own values where a
/// record is the centre or radius of a fit.
DesignTable design_table(const StudyFile& study, const std::vector<StoredPoint>& rows, double coverage);

/// A TOML string without its quotes; anything else as it is.
std::string plain_value(const std::string& toml);
/// "ball radius_mm" of "fits.ball.measured.radius_mm"; any other name as it is.
std::string display_name(const std::string& path);
/// "mm" of "fits.ball.measured.center_mm[2]"; empty when the name does not say.
std::string unit_of(const std::string& path);

}  // namespace fringetwin::study
