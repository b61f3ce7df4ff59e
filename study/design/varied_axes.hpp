// SPDX-License-Identifier: Apache-2.0
// What varies in a design, as axes of its report; internal to study/.
#pragma once
#include <vector>

#include "study/design/design_table.hpp"

namespace fringetwin::study {

/// Axes, and the levels of the table's settings, which these are the TOML texts of.
void add_axes(const StudyFile& study, const std::vector<const Settings*>& settings, DesignTable* table);

/// Likewise for other tables of values, each an axis.
void add_axes(const std::vector<Variation>& variations, const std::vector<const Settings*>& settings,
              DesignTable* table);

/// A value as it is shown: a number with eight digits, a string without its quotes.
std::string level_name(const std::string& toml);

}  // namespace fringetwin::study
