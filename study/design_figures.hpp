// SPDX-License-Identifier: Apache-2.0
// The drawings of one recorded number of a design; internal to study/.
#pragma once
#include <string>
#include <vector>

#include "study/design_table.hpp"
#include "study/figure_sheet.hpp"

namespace fringetwin::study {

/// More levels than this are no curves of their own.
inline constexpr std::size_t kMostCurves = 6;
/// Axes, and pairs of them, that are drawn per number.
inline constexpr std::size_t kMostAxes = 8, kMostPairs = 6;

/// Of the settings at each level of an axis; `other` and `at`: only those at this level of another one.
std::vector<GroupStatistics> by_level(const DesignTable& table, const TableNumber& number, std::size_t axis,
                                      std::size_t other = SIZE_MAX, std::size_t at = 0);

/// Mean and sigma against each axis.
std::string axis_figures(const DesignTable& table, const TableNumber& number, FigureSheet* sheet);
/// Heat maps of pairs of axes of a grid; empty where there is no pair.
std::string pair_figures(const DesignTable& table, const TableNumber& number, FigureSheet* sheet);
/// Time against uncertainty; empty unless the time is recorded and there is something to set against it.
std::string pareto_figures(const DesignTable& table, const TableNumber& time,
                           const std::vector<const TableNumber*>& numbers, FigureSheet* sheet);
/// How many drawings one number takes.
std::size_t drawings_per_number(const DesignTable& table);

/// "bit_depth 8, gain_dn 20"
std::string setting_text(const DesignTable& table, std::size_t setting);
/// Long names end in an ellipsis.
std::string shortened(const std::string& name, std::size_t most = 24);

}  // namespace fringetwin::study
