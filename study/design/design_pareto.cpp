// SPDX-License-Identifier: Apache-2.0
// Draws acquisition time against uncertainty of a design's settings.
#include <fmt/format.h>

#include "report/table.hpp"
#include "report/text.hpp"
#include "study/design/design_figures.hpp"
#include "study/page/pareto_plot.hpp"
#include "study/page/report_parts.hpp"

namespace fringetwin::study {
namespace {

constexpr std::size_t kMostRows = 20;

struct Shown {
  const char* word;
  double GroupStatistics::*value;
};

/// Returns time and `value` of every setting; NaN where a seed is missing: of few seeds the scatter may be
/// small by chance, and what failed may be bad.
std::vector<CostAndError> points_of(const DesignTable& table, const TableNumber& time,
                                    const TableNumber& number, double GroupStatistics::*value) {
  std::vector<CostAndError> out;
  for (std::size_t s = 0; s < number.runs.size(); ++s) {
    const bool whole = number.runs[s].size() == table.seeds;
    out.push_back({group_statistics({&time.runs[s]}, kReportCoverage).mean,
                   whole ? group_statistics({&number.runs[s]}, kReportCoverage).*value : kNan});
  }
  return out;
}

std::string front_table(const DesignTable& table, const std::vector<CostAndError>& points,
                        const std::vector<std::size_t>& front, const std::string& header) {
  report::Table out;
  out.caption =
      "The front: no other setting is at most as long and at most as uncertain. Settings without a value "
      "from every seed take no part.";
  out.columns = {report::text_column(""), report::text_column("setting"), {"time", "s"}, {header}};
  for (std::size_t i = 0; i < std::min(front.size(), kMostRows); ++i)
    out.add_row({front_mark(i), setting_text(table, front[i]), report::number(points[front[i]].cost),
                 report::number(points[front[i]].error, 3)});
  return out.html();
}

}  // namespace

std::string pareto_figures(const DesignTable& table, const TableNumber& time,
                           const std::vector<const TableNumber*>& numbers, FigureSheet* sheet) {
  const Shown sigma{"sigma over seeds", &GroupStatistics::sigma}, rms{"rms error", &GroupStatistics::rms};
  std::string out;
  for (const TableNumber* number : numbers) {
    if (number->is_time) continue;
    std::vector<Shown> shown;
    if (number->all.sigma > 0.0) shown.push_back(sigma);
    if (number->is_error) shown.push_back(rms);
    for (const Shown& s : shown) {
      const std::vector<CostAndError> points = points_of(table, time, *number, s.value);
      const std::vector<std::size_t> front = pareto_front(points);
      if (front.empty()) continue;
      report::Plot plot = front_plot(points, front, "settings");
      plot.y_label = with_unit(s.word, number->unit);
      plot.title = fmt::format("{} of {} against time", s.word, shortened(number->name, 48));
      out +=
          report::figure_html(sheet->place(fmt::format("{}-pareto-{}", number->name, s.word), plot),
                              "Steps: between two points of the front the cheaper one is what can be had.");
      out += front_table(table, points, front, with_unit(s.word, number->unit));
    }
  }
  return out;
}

}  // namespace fringetwin::study
