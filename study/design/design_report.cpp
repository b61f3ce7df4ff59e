// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "study/design/design_figures.hpp"
#include "study/design/design_plan.hpp"
#include "study/design/design_tables.hpp"
#include "study/page/report_parts.hpp"

namespace fringetwin::study {
namespace {

constexpr std::size_t kMostDrawn = 8, kMostDrawings = 100;

const char* design_name(Design design) {
  switch (design) {
    case Design::grid:
      return "a grid";
    case Design::list:
      return "a list";
    case Design::latin_hypercube:
      return "a Latin hypercube";
    case Design::sobol:
      return "a Sobol design";
  }
  return "";
}

/// Returns whether there are measured numbers, and none of them scatters. One without values says nothing.
bool seeds_made_no_difference(const DesignTable& table) {
  const auto has_sigma = [](const TableNumber& n) { return n.is_measured && std::isfinite(n.all.sigma); };
  return std::ranges::any_of(table.numbers, has_sigma) &&
         std::ranges::none_of(table.numbers, &TableNumber::has_scatter);
}

std::string note_of(const DesignPlan& plan, const DesignTable& table) {
  std::string out;
  const int seeds = plan.noise_seeds;
  if (seeds > 1) {
    const double dof = seeds - 1.0;
    const Interval s = sigma_interval(1.0, dof, kReportCoverage);
    out += fmt::format(
        "Scatter over {} seeds: the true sigma of a setting lies between {:.2f} and {:.2f} times the one "
        "shown, its mean is known to ±{:.2f} sigma (95 %, normal scatter). ",
        seeds, s.low, s.high, student_t_quantile(0.5 + 0.5 * kReportCoverage, dof) / std::sqrt(seeds));
    if (table.settings.size() > 1)
      out +=
          "All settings share their seeds: where the noise acts alike, differences between settings are "
          "known better than their bands say, and averages over settings no better than one of them. ";
    if (seeds_made_no_difference(table))
      out += "The seeds made no difference: the twin has no noise, or none that reaches these numbers. ";
  } else {
    out +=
        "One run per setting: its scatter is not known, and differences between settings contain the noise. ";
  }
  if (table.axes.size() > 1)
    out += table.scattered
               ? "The other parameters vary along with the one that is drawn: a running mean is over their "
                 "whole ranges. "
               : "A curve over some parameters is an average over the listed values of the others. ";
  return out +
         "An error is that of the measurement of this twin: what the twin leaves out is in none of the "
         "numbers.";
}

/// Returns how many numbers are drawn: few enough that the page stays readable.
std::size_t numbers_drawn(const DesignTable& table) {
  const std::size_t each = std::max(drawings_per_number(table), std::size_t{1});
  return std::min(table.numbers.size(), std::clamp(kMostDrawings / each, std::size_t{2}, kMostDrawn));
}

std::string left_out(const StudyRecord& study, const DesignTable& table, std::size_t drawn) {
  std::string out;
  if (drawn < table.numbers.size())
    out += fmt::format("<p>Of the numbers {} are drawn, {}; the others are in the table only.</p>",
                       shown_of(drawn, table.numbers.size()),
                       study.head.records.empty()
                           ? "those with a known truth first, then those that change most against their noise"
                           : "in the order of the [[record]]s");
  if (table.axes.size() > kMostAxes)
    out += fmt::format("<p>Of the parameters {} are drawn.</p>", shown_of(kMostAxes, table.axes.size()));
  const AxisPairs pairs = axis_pairs(table);
  if (!pairs.large.empty())
    out += fmt::format("<p>Heat maps of more than {} cells are left out: {} pair{} of parameters.</p>",
                       kMostCells, pairs.large.size(), pairs.large.size() == 1 ? "" : "s");
  if (pairs.small.size() > kMostPairs)
    out += fmt::format("<p>Of the {}pairs of parameters {} have heat maps.</p>",
                       pairs.large.empty() ? "" : "other ", shown_of(kMostPairs, pairs.small.size()));
  return out;
}

}  // namespace

StudyReport design_report(const StudyRecord& study, const DesignPlan& plan) {
  const DesignTable table = design_table(study.head, plan, study.rows, kReportCoverage);
  FigureSheet sheet;
  report::Page page =
      page_of(study, fmt::format("{} of {} settings, {} noise seed{} each, on the twin {}",
                                 design_name(plan.design), table.settings.size(), plan.noise_seeds,
                                 plan.noise_seeds == 1 ? "" : "s", study.head.twin.filename().string()));
  page.summary_html = varied_table(table) + page.summary_html;
  page.note = note_of(plan, table);
  const std::size_t drawn = numbers_drawn(table);
  page.sections.push_back({"numbers", "Numbers",
                           numbers_table(table, drawn) + effects_table(table, drawn) +
                               left_out(study, table, drawn) + settings_table(table, drawn)});
  add_failures(study, &page);
  std::vector<const TableNumber*> shown;
  for (std::size_t k = 0; k < drawn; ++k) shown.push_back(&table.numbers[k]);
  for (const TableNumber& time : table.numbers)
    if (time.is_time)
      if (const std::string pareto = pareto_figures(table, time, shown, &sheet); !pareto.empty())
        page.sections.push_back({"pareto", "Time against uncertainty", pareto});
  for (std::size_t k = 0; k < drawn; ++k) {
    const TableNumber& n = table.numbers[k];
    std::string body = axis_figures(table, n, &sheet);
    body += pair_figures(table, n, &sheet);
    body += expected_table(table, n);
    if (table.axes.empty()) body += "<p>Nothing varies but the noise: mean and sigma are in the table.</p>";
    page.sections.push_back({"number-" + std::to_string(k), n.name, body});
  }
  return sheet.finish(page.html());
}

}  // namespace fringetwin::study
