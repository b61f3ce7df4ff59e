// SPDX-License-Identifier: Apache-2.0
// Acquisition time against uncertainty of a design's settings.
#include <fmt/format.h>

#include <cmath>

#include "report/table.hpp"
#include "report/text.hpp"
#include "study/design_figures.hpp"
#include "study/front.hpp"
#include "study/report_parts.hpp"

namespace fringetwin::study {
namespace {

using report::Plot, report::Series;

constexpr std::size_t kMostLabels = 8, kMostRows = 20;

struct Shown {
  const char* word;
  double GroupStatistics::*value;
};

std::vector<CostAndError> points_of(const TableNumber& time, const TableNumber& number,
                                    double GroupStatistics::*value) {
  std::vector<CostAndError> out;
  for (std::size_t s = 0; s < number.runs.size(); ++s)
    out.push_back({group_statistics({&time.runs[s]}, kReportCoverage).mean,
                   group_statistics({&number.runs[s]}, kReportCoverage).*value});
  return out;
}

Plot front_plot(const DesignTable& table, const std::vector<CostAndError>& points,
                const std::vector<std::size_t>& front) {
  Plot plot;
  plot.width_px = 980;
  plot.height_px = 400;
  plot.x_label = "acquisition time [s]";
  std::vector<double> costs, errors;
  Series all{.title = "settings",
             .x = {},
             .y = {},
             .y_low = {},
             .style = Series::Style::points,
             .color = "#7fb2d0",
             .width = 2.0};
  for (const CostAndError& p : points) all.x.push_back(p.cost), all.y.push_back(p.error);
  plot.log_x = spans_a_decade(all.x);
  plot.log_y = spans_a_decade(all.y);
  Series steps{.title = "Pareto front",
               .x = {},
               .y = {},
               .y_low = {},
               .style = Series::Style::dashed,
               .color = report::color::kDifference};
  Series marked{.title = "",
                .x = {},
                .y = {},
                .y_low = {},
                .style = Series::Style::points,
                .color = report::color::kSimulated,
                .width = 3.2};
  for (std::size_t i = 0; i < front.size(); ++i) {
    const CostAndError& p = points[front[i]];
    if (i > 0) steps.x.push_back(p.cost), steps.y.push_back(points[front[i - 1]].error);
    steps.x.push_back(p.cost);
    steps.y.push_back(p.error);
    marked.x.push_back(p.cost);
    marked.y.push_back(p.error);
    marked.labels.push_back(front.size() <= kMostLabels ? shortened(setting_text(table, front[i]), 44) : "");
  }
  plot.series = {all, steps, marked};
  return plot;
}

std::string front_table(const DesignTable& table, const std::vector<CostAndError>& points,
                        const std::vector<std::size_t>& front, const std::string& header) {
  report::Table out;
  out.caption = "The front: no other setting is at most as long and at most as uncertain.";
  out.columns = {{"setting", "", report::Align::left}, {"time", "s"}, {header, ""}};
  for (std::size_t i = 0; i < std::min(front.size(), kMostRows); ++i)
    out.add_row({setting_text(table, front[i]), report::number(points[front[i]].cost),
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
      const std::vector<CostAndError> points = points_of(time, *number, s.value);
      const std::vector<std::size_t> front = pareto_front(points);
      if (front.empty()) continue;
      Plot plot = front_plot(table, points, front);
      plot.y_label = with_unit(s.word, number->unit);
      plot.title = fmt::format("{} of {} against time", s.word, shortened(number->name, 48));
      out +=
          report::Figure{sheet->place(fmt::format("{}-pareto-{}", number->name, s.word), plot),
                         "Steps: between two points of the front the cheaper one is what can be had.", "", ""}
              .html();
      out += front_table(table, points, front, with_unit(s.word, number->unit));
    }
  }
  return out;
}

}  // namespace fringetwin::study
