// SPDX-License-Identifier: Apache-2.0
// The page of a design.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/table.hpp"
#include "report/text.hpp"
#include "study/design_figures.hpp"
#include "study/report_parts.hpp"

namespace fringetwin::study {
namespace {

using report::Align, report::number;

constexpr std::size_t kMostDrawn = 8, kMostDrawings = 100, kMostSettings = 200;

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

std::string varied_table(const DesignTable& table) {
  report::Table out;
  out.caption = "What was varied.";
  out.columns = {
      {"parameter", "", Align::left}, {"values", ""}, {"", "", Align::left}, {"keys", "", Align::left}};
  std::vector<VariedAxis> all = table.axes;
  all.insert(all.end(), table.fixed.begin(), table.fixed.end());
  for (const VariedAxis& a : all) {
    std::string values;
    if (a.names.size() <= 12)
      for (const std::string& name : a.names) values += (values.empty() ? "" : ", ") + shortened(name);
    else
      values = shortened(a.names.front()) + " … " + shortened(a.names.back());
    out.add_row({a.brief, std::to_string(a.names.size()), values, a.label});
  }
  return all.empty() ? "<p>Nothing was varied but the seed of the noise.</p>" : out.html();
}

std::string band_text(double value, const Interval& band) {
  if (std::isnan(value)) return "–";
  return std::isnan(band.low)
             ? number(value, 4)
             : fmt::format("{} ({} … {})", number(value, 4), number(band.low, 3), number(band.high, 3));
}

std::string numbers_table(const DesignTable& table, std::size_t drawn) {
  report::Table out;
  out.caption = "Every recorded number over all settings. Error: measured minus what the twin puts in.";
  out.columns = {{"number", "", Align::left},
                 {"", "", Align::left},
                 {"runs", ""},
                 {"mean", ""},
                 {"least … greatest", "of the settings' means"},
                 {"sigma over seeds", "95 % band"},
                 {"change / noise", "ratio of variances"},
                 {"", "", Align::left}};
  for (std::size_t k = 0; k < table.numbers.size(); ++k) {
    const TableNumber& n = table.numbers[k];
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const SettingRuns& runs : n.runs) {
      const double mean = group_statistics({&runs}, kReportCoverage).mean;
      if (!std::isnan(mean)) low = std::min(low, mean), high = std::max(high, mean);
    }
    out.add_row({with_unit(n.name, n.unit), n.is_error ? "error" : "value", std::to_string(n.all.runs),
                 number(n.all.mean, 5), low <= high ? number(low, 5) + " … " + number(high, 5) : "–",
                 band_text(n.all.sigma, n.all.sigma_band),
                 n.change >= 1e300 ? "no noise" : number(n.change, 3), k < drawn ? "drawn" : "table only"});
  }
  return out.html();
}

/// The levels with the least and the greatest value, and whether their bands keep apart.
struct Extremes {
  double low = HUGE_VAL, high = -HUGE_VAL;
  std::size_t low_at = 0, high_at = 0;
  bool known = false, apart = false;
};
Extremes extremes(const std::vector<GroupStatistics>& levels, double GroupStatistics::*value,
                  Interval GroupStatistics::*band) {
  Extremes out;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double v = levels[i].*value;
    if (std::isnan(v)) continue;
    if (v < out.low) out.low = v, out.low_at = i;
    if (v > out.high) out.high = v, out.high_at = i;
  }
  if (out.low > out.high) return out;
  const Interval &a = levels[out.low_at].*band, &b = levels[out.high_at].*band;
  out.known = !std::isnan(a.high) && !std::isnan(b.low) && out.low_at != out.high_at;
  out.apart = out.known && a.high < b.low;
  return out;
}

std::string verdict(const Extremes& e) { return !e.known ? "not known" : e.apart ? "yes" : "no"; }

std::string effects_table(const DesignTable& table, std::size_t drawn) {
  report::Table out;
  out.caption =
      "What changes what: the levels of a parameter with the least and the greatest value, averaged over "
      "all others. “Told from chance”: the 95 % bands of the two do not overlap.";
  out.columns = {
      {"number", "", Align::left}, {"parameter", "", Align::left},        {"least … greatest mean", ""},
      {"at", "", Align::left},     {"told from chance", "", Align::left}, {"least … greatest sigma", ""},
      {"at", "", Align::left},     {"told from chance", "", Align::left}};
  for (std::size_t k = 0; k < drawn; ++k)
    for (std::size_t a = 0; a < std::min(table.axes.size(), kMostAxes); ++a) {
      const VariedAxis& axis = table.axes[a];
      if (table.scattered && axis.numeric) continue;
      const auto levels = by_level(table, table.numbers[k], a);
      std::size_t known = 0;
      for (const GroupStatistics& g : levels) known += std::isfinite(g.mean);
      if (known < 2) continue;
      std::vector<std::string> row = {with_unit(table.numbers[k].name, table.numbers[k].unit), axis.brief};
      const auto add = [&](const Extremes& e, int digits) {
        const bool any = e.low <= e.high;
        row.push_back(any ? number(e.low, digits) + " … " + number(e.high, digits) : "–");
        row.push_back(any ? shortened(axis.names[e.low_at], 14) + " … " + shortened(axis.names[e.high_at], 14)
                          : "");
        row.push_back(any ? verdict(e) : "");
      };
      add(extremes(levels, &GroupStatistics::mean, &GroupStatistics::mean_band), 5);
      add(extremes(levels, &GroupStatistics::sigma, &GroupStatistics::sigma_band), 3);
      out.add_row(row);
    }
  return out.rows.empty() ? "" : out.html();
}

/// Ratios to what is expected, per setting.
std::string expected_table(const DesignTable& table, const TableNumber& n) {
  if (n.expected_mean.empty() && n.expected_sigma.empty()) return "";
  report::Table out;
  out.columns = {{"setting", "", Align::left},
                 {"mean", n.unit},
                 {"expected", n.unit},
                 {"ratio", ""},
                 {"sigma", n.unit},
                 {"expected", n.unit},
                 {"ratio", "95 % band"}};
  double low = HUGE_VAL, high = 0.0;
  for (std::size_t s = 0; s < std::min(n.runs.size(), kMostSettings); ++s) {
    const GroupStatistics g = group_statistics({&n.runs[s]}, kReportCoverage);
    const double mean = n.expected_mean.empty() ? kNan : n.expected_mean[s],
                 sigma = n.expected_sigma.empty() ? kNan : n.expected_sigma[s];
    const double ratio = n.expected_sigma.empty() ? g.mean / mean : g.sigma / sigma;
    if (std::isfinite(ratio)) low = std::min(low, ratio), high = std::max(high, ratio);
    const Interval band{g.sigma_band.low / sigma, g.sigma_band.high / sigma};
    out.add_row({setting_text(table, s), number(g.mean, 5), number(mean, 5),
                 n.is_error ? "" : report::fixed(g.mean / mean, 3), number(g.sigma, 3), number(sigma, 3),
                 std::isfinite(g.sigma / sigma)
                     ? fmt::format("{:.3f} ({:.3f} … {:.3f})", g.sigma / sigma, band.low, band.high)
                     : "–"});
  }
  return fmt::format("<details><summary>Against what is expected{}</summary>{}</details>",
                     low <= high ? fmt::format(": {} is {:.3f} … {:.3f} times as large",
                                               n.expected_sigma.empty() ? "the mean" : "sigma", low, high)
                                 : "",
                     out.html());
}

std::string settings_table(const DesignTable& table, std::size_t drawn) {
  report::Table out;
  out.columns = {{"setting", "", Align::left}, {"runs", ""}};
  for (std::size_t k = 0; k < drawn; ++k) {
    out.columns.push_back(
        {table.numbers[k].name, table.numbers[k].unit + (table.numbers[k].is_error ? " error" : "")});
    out.columns.push_back({"sigma", table.numbers[k].unit});
  }
  for (std::size_t s = 0; s < std::min(table.settings.size(), kMostSettings); ++s) {
    std::vector<std::string> row = {setting_text(table, s), ""};
    std::size_t runs = 0;
    for (std::size_t k = 0; k < drawn; ++k) {
      const GroupStatistics g = group_statistics({&table.numbers[k].runs[s]}, kReportCoverage);
      runs = std::max(runs, g.runs);
      row.push_back(number(g.mean, 6));
      row.push_back(number(g.sigma, 3));
    }
    row[1] = std::to_string(runs);
    out.add_row(row);
  }
  const std::string shown = shown_of(out.rows.size(), table.settings.size());
  return fmt::format("<details><summary>{} settings, mean and sigma over their seeds{}</summary>{}</details>",
                     table.settings.size(), shown.empty() ? "" : " (" + shown + "; all runs: study.csv)",
                     out.html());
}

std::string note_of(const StudyRecord& study, const DesignTable& table) {
  std::string out;
  const int seeds = study.file.noise_seeds;
  if (seeds > 1) {
    const double dof = seeds - 1.0;
    const Interval s = sigma_interval(1.0, dof, kReportCoverage);
    out += fmt::format(
        "Scatter over {} seeds: the true sigma of a setting lies between {:.2f} and {:.2f} times the one "
        "shown, its "
        "mean is known to ±{:.2f} sigma (95 %, normal scatter). ",
        seeds, s.low, s.high, student_t_quantile(0.5 + 0.5 * kReportCoverage, dof) / std::sqrt(seeds));
    if (table.settings.size() > 1)
      out +=
          "All settings share their seeds: where the noise acts alike, differences between settings are "
          "known "
          "better than their bands say, and averages over settings no better than one of them. ";
    bool any = false;
    for (const TableNumber& n : table.numbers) any = any || n.all.sigma > 0.0;
    if (!any) out += "The seeds made no difference: the twin has no noise. ";
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

/// Few enough that the page stays readable.
std::size_t numbers_drawn(const DesignTable& table) {
  const std::size_t each = std::max(drawings_per_number(table), std::size_t{1});
  return std::min(table.numbers.size(), std::clamp(kMostDrawings / each, std::size_t{2}, kMostDrawn));
}

std::string left_out(const StudyRecord& study, const DesignTable& table, std::size_t drawn) {
  std::string out;
  if (drawn < table.numbers.size())
    out += fmt::format("<p>{} numbers are drawn, {}; the others are in the table only.</p>",
                       shown_of(drawn, table.numbers.size()),
                       study.file.records.empty()
                           ? "those with a known truth first, then those that change most against their noise"
                           : "in the order of the [[record]]s");
  if (table.axes.size() > kMostAxes)
    out += fmt::format("<p>{} parameters are drawn.</p>", shown_of(kMostAxes, table.axes.size()));
  const std::size_t axes = std::min(table.axes.size(), kMostAxes),
                    pairs = axes > 0 ? axes * (axes - 1) / 2 : 0;
  if (!table.scattered && pairs > kMostPairs)
    out += fmt::format("<p>{} pairs of parameters have heat maps.</p>", shown_of(kMostPairs, pairs));
  return out;
}

}  // namespace

StudyReport design_report(const StudyRecord& study) {
  const DesignTable table = design_table(study.file, study.rows, kReportCoverage);
  FigureSheet sheet;
  report::Page page = page_of(
      study, fmt::format("{} of {} settings, {} noise seed{} each, on the twin {}",
                         design_name(study.file.design), table.settings.size(), study.file.noise_seeds,
                         study.file.noise_seeds == 1 ? "" : "s", study.file.twin.filename().string()));
  page.summary_html = varied_table(table) + page.summary_html;
  page.note = note_of(study, table);
  const std::size_t drawn = numbers_drawn(table);
  page.sections.push_back({"numbers", "Numbers",
                           numbers_table(table, drawn) + effects_table(table, drawn) +
                               left_out(study, table, drawn) + settings_table(table, drawn)});
  if (const std::string failures = failures_html(study); !failures.empty())
    page.sections.push_back({"failures", "Failures", failures});
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
