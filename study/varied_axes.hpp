// SPDX-License-Identifier: Apache-2.0
// What varies in a design, as axes of its report; internal to study/.
#pragma once
#include <vector>

#include "study/design_table.hpp"

namespace fringetwin::study {

/// Axes, and the levels of the table's settings, which these are the TOML texts of.
void add_axes(const StudyFile& study, const std::vector<const Settings*>& settings, DesignTable* table);

}  // namespace fringetwin::study
