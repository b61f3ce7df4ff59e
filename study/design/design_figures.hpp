// SPDX-License-Identifier: Apache-2.0
// Makes the drawings of one recorded number of a design; internal to study/.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "study/design/design_table.hpp"
#include "study/page/figure_sheet.hpp"
#include "study/page/report_parts.hpp"

namespace fringetwin::study {

/// More levels than this are no curves of their own.
inline constexpr std::size_t kMostCurves = 6;
/// Pairs of axes that are drawn per number.
inline constexpr std::size_t kMostPairs = 6;
/// Cells of a heat map, and levels along an axis, that are drawn: the page stays readable, and quick to make.
inline constexpr std::size_t kMostCells = 3600, kMostLevels = 500;

/// Returns the statistics of the settings at each level of an axis; `other` and `at`: only of those at this
/// level of another one.
std::vector<GroupStatistics> by_level(const DesignTable& table, const TableNumber& number, std::size_t axis,
                                      std::size_t other = SIZE_MAX, std::size_t at = 0,
                                      double coverage = kReportCoverage);
/// Returns the coverage of the bands that tell the least of some levels from the greatest: any two of them
/// might have been these (Bonferroni).
double coverage_of_extremes(std::size_t levels);

/// Returns the drawings of mean and sigma against each axis.
std::string axis_figures(const DesignTable& table, const TableNumber& number, FigureSheet* sheet);
/// Pairs of the drawn axes of a grid whose heat map has few enough cells, and those whose has too many.
struct AxisPairs {
  std::vector<std::pair<std::size_t, std::size_t>> small, large;
};
/// Returns the pairs of the drawn axes.
AxisPairs axis_pairs(const DesignTable& table);
/// Returns the heat maps of the small pairs; an empty string where there is none.
std::string pair_figures(const DesignTable& table, const TableNumber& number, FigureSheet* sheet);
/// Returns the drawings of time against uncertainty; an empty string unless the time is recorded and there is
/// something to set against it.
std::string pareto_figures(const DesignTable& table, const TableNumber& time,
                           const std::vector<const TableNumber*>& numbers, FigureSheet* sheet);
/// Returns how many drawings one number takes.
std::size_t drawings_per_number(const DesignTable& table);

/// Returns the values of a setting, "bit_depth 8, gain_dn 20".
std::string setting_text(const DesignTable& table, std::size_t setting);

}  // namespace fringetwin::study
