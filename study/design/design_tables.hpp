// SPDX-License-Identifier: Apache-2.0
// Makes the tables of a design's page, as HTML; internal to study/. `drawn`: how many of the numbers are
// drawn.
#pragma once
#include <string>

#include "study/design/design_table.hpp"

namespace fringetwin::study {

/// Returns the table of what varies, with its values.
std::string varied_table(const DesignTable& table);
/// Returns the table of every recorded number over all settings.
std::string numbers_table(const DesignTable& table, std::size_t drawn);
/// Returns the table of which parameter changes which number, told from chance or not; an empty string where
/// there is nothing to compare.
std::string effects_table(const DesignTable& table, std::size_t drawn);
/// Returns the ratios to what is expected, per setting; an empty string where nothing is.
std::string expected_table(const DesignTable& table, const TableNumber& number);
/// Returns the table of the settings with the means and sigmas of their numbers.
std::string settings_table(const DesignTable& table, std::size_t drawn);

}  // namespace fringetwin::study
