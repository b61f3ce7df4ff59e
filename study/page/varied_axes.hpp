// SPDX-License-Identifier: Apache-2.0
// What varies between the settings of a study, as axes of its page: from the [[vary]] or [[choose]] and the
// settings that occurred to levels with their names, and the empty plot along an axis.
#pragma once
#include <string>
#include <vector>

#include "report/plot/plot.hpp"
#include "study/plan/study_point.hpp"
#include "study/plan/study_tables.hpp"

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

struct VariedSettings {
  std::vector<VariedAxis> axes;   ///< with two levels or more
  std::vector<VariedAxis> fixed;  ///< with one
  std::vector<Setting> settings;
};

/// Axes that are drawn per number.
inline constexpr std::size_t kMostAxes = 8;

/// Adds an axis for each variation, and its levels to the settings, whose TOML texts are `settings`.
void add_axes(const std::vector<Variation>& variations, const std::vector<const Settings*>& settings,
              VariedSettings* varied);
/// Likewise one axis for all variations together: the values of a list stand side by side.
void add_joint_axis(const std::vector<Variation>& variations, const std::vector<const Settings*>& settings,
                    VariedSettings* varied);

/// Returns a value as it is shown: a number with eight digits, a string without its quotes.
std::string level_name(const std::string& toml);

/// Returns a plot without data: x along this axis, with its levels as tics where there is room.
report::Plot axis_plot(const VariedAxis& axis);

}  // namespace fringetwin::study
