// SPDX-License-Identifier: Apache-2.0
#include "study/design/design_figures.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "report/text.hpp"
#include "study/page/report_parts.hpp"
#include "study/plan/recorded_numbers.hpp"

namespace fringetwin::study {

std::string setting_text(const DesignTable& table, std::size_t setting) {
  std::string out;
  for (std::size_t k = 0; k < table.axes.size(); ++k)
    out += fmt::format("{}{} {}", out.empty() ? "" : ", ", table.axes[k].brief,
                       shortened(table.axes[k].names[table.settings[setting].level[k]]));
  return out.empty() ? "the twin itself" : out;
}

std::vector<GroupStatistics> by_level(const DesignTable& table, const TableNumber& number, std::size_t axis,
                                      std::size_t other, std::size_t at, double coverage) {
  std::vector<std::vector<const SettingRuns*>> groups(table.axes[axis].values.size());
  for (std::size_t s = 0; s < table.settings.size(); ++s)
    if (other == SIZE_MAX || table.settings[s].level[other] == at)
      groups[table.settings[s].level[axis]].push_back(&number.runs[s]);
  std::vector<GroupStatistics> out;
  for (const auto& group : groups) out.push_back(group_statistics(group, coverage));
  return out;
}

double coverage_of_extremes(std::size_t levels) {
  const auto n = static_cast<double>(std::max(levels, std::size_t{2}));
  return 1.0 - (1.0 - kReportCoverage) / (0.5 * n * (n - 1.0));
}

std::size_t drawings_per_number(const DesignTable& table) {
  return 2 * (std::min(table.axes.size(), kMostAxes) + std::min(axis_pairs(table).small.size(), kMostPairs));
}

AxisPairs axis_pairs(const DesignTable& table) {
  AxisPairs out;
  if (table.scattered) return out;
  const std::size_t axes = std::min(table.axes.size(), kMostAxes);
  for (std::size_t i = 0; i < axes; ++i)
    for (std::size_t k = i + 1; k < axes; ++k)
      (table.axes[i].values.size() * table.axes[k].values.size() <= kMostCells ? out.small : out.large)
          .emplace_back(i, k);
  return out;
}

std::string pair_figures(const DesignTable& table, const TableNumber& number, FigureSheet* sheet) {
  std::string out;
  std::vector<std::pair<std::size_t, std::size_t>> pairs = axis_pairs(table).small;
  pairs.resize(std::min(pairs.size(), kMostPairs));
  for (const auto& [i, k] : pairs) {
    const VariedAxis &x = table.axes[i], &y = table.axes[k];
    report::HeatMap mean;
    mean.x_label = with_unit(x.label, unit_of(x.label));
    mean.y_label = with_unit(y.label, unit_of(y.label));
    for (const std::string& name : x.names) mean.x_names.push_back(shortened(name, 14));
    for (const std::string& name : y.names) mean.y_names.push_back(shortened(name, 14));
    report::HeatMap sigma = mean;
    for (std::size_t level = 0; level < y.values.size(); ++level) {
      std::vector<double> means, sigmas;
      for (const GroupStatistics& g : by_level(table, number, i, k, level))
        means.push_back(g.mean), sigmas.push_back(g.sigma);
      mean.values.push_back(means);
      sigma.values.push_back(sigmas);
    }
    mean.title = fmt::format("{} of {}", number.is_error ? "mean error" : "mean",
                             with_unit(shortened(number.name, 40), number.unit));
    mean.limits = report::limits_of(mean.values, report::Scale::viridis);
    if (number.is_error && mean.limits.low < 0.0 && mean.limits.high > 0.0) {
      mean.scale = report::Scale::diverging;
      mean.limits = report::limits_of(mean.values, mean.scale);
    }
    const std::string name = fmt::format("{}-{}-{}", number.name, x.brief, y.brief);
    std::vector<std::string> row = {sheet->place(name + "-mean", mean)};
    if (number.has_scatter()) {
      sigma.title = "sigma over seeds of " + with_unit(shortened(number.name, 40), number.unit);
      sigma.limits = report::limits_of(sigma.values, sigma.scale);
      std::vector<double> all;
      for (const auto& line : sigma.values) all.insert(all.end(), line.begin(), line.end());
      sigma.log_color = spans_a_decade(all);
      row.push_back(sheet->place(name + "-sigma", sigma));
    }
    out += report::figure_html(FigureSheet::row(row), table.axes.size() > 2
                                                          ? "Averaged over the other parameters."
                                                          : "One cell per setting.");
  }
  return out;
}

}  // namespace fringetwin::study
