// SPDX-License-Identifier: Apache-2.0
// The tables of a design's page, as HTML; internal to study/. `drawn`: how many of the numbers are drawn.
#pragma once
#include <string>

#include "study/design/design_table.hpp"

namespace fringetwin::study {

std::string varied_table(const DesignTable& table);
/// Every recorded number over all settings.
std::string numbers_table(const DesignTable& table, std::size_t drawn);
/// Which parameter changes which number, told from chance or not; empty where there is nothing to compare.
std::string effects_table(const DesignTable& table, std::size_t drawn);
/// Ratios to what is expected, per setting; empty where nothing is.
std::string expected_table(const DesignTable& table, const TableNumber& number);
std::string settings_table(const DesignTable& table, std::size_t drawn);

}  // namespace fringetwin::study
