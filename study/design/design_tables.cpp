// SPDX-License-Identifier: Apache-2.0
#include "study/design/design_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/table.hpp"
#include "report/text.hpp"
#include "study/design/design_figures.hpp"
#include "study/page/report_parts.hpp"

namespace fringetwin::study {
namespace {

using report::number, report::text_column;

constexpr std::size_t kMostSettings = 200;

/// Returns two numbers with the digits that tell them apart.
std::string range_text(double low, double high) {
  if (!(low <= high)) return "–";
  if (low == high) return number(low, 4);
  const int digits = needs_many_digits({low, high}) ? 10 : 4;
  return number(low, digits) + " … " + number(high, digits);
}

std::string band_text(double value, const Interval& band) {
  if (std::isnan(value)) return "–";
  return std::isnan(band.low)
             ? number(value, 4)
             : fmt::format("{} ({} … {})", number(value, 4), number(band.low, 3), number(band.high, 3));
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

}  // namespace

std::string varied_table(const DesignTable& table) {
  report::Table out;
  out.caption = "What was varied.";
  out.columns = {text_column("parameter"), {"values"}, text_column(""), text_column("keys")};
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

std::string numbers_table(const DesignTable& table, std::size_t drawn) {
  report::Table out;
  out.caption = "Every recorded number over all settings. Error: measured minus what the twin puts in.";
  out.columns = {text_column("number"),
                 text_column(""),
                 {"runs"},
                 {"mean"},
                 {"least … greatest", "of the settings' means"},
                 {"sigma over seeds", "95 % band"},
                 {"change / noise", "ratio of variances; no change: 0 … 1"},
                 text_column("")};
  for (std::size_t k = 0; k < table.numbers.size(); ++k) {
    const TableNumber& n = table.numbers[k];
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const SettingRuns& runs : n.runs) {
      const double mean = group_statistics({&runs}, kReportCoverage).mean;
      if (!std::isnan(mean)) low = std::min(low, mean), high = std::max(high, mean);
    }
    out.add_row({with_unit(n.name, n.unit), n.is_error ? "error" : "value", std::to_string(n.all.runs),
                 number(n.all.mean, needs_many_digits({low, high}) ? 10 : 4), range_text(low, high),
                 band_text(n.all.sigma, n.all.sigma_band),
                 n.change >= 1e300 ? "no noise" : number(n.change, 3), k < drawn ? "drawn" : "table only"});
  }
  return out.html();
}

std::string effects_table(const DesignTable& table, std::size_t drawn) {
  report::Table out;
  out.caption =
      "What changes what: the levels of a parameter with the least and the greatest value, averaged over all "
      "others. “Told from chance”: the bands of the two do not overlap; of L levels they are of 1 - "
      "0.05/(L(L - 1)/2), as any two could have been the extremes by chance.";
  const bool repeated =
      std::ranges::any_of(table.numbers, [](const TableNumber& n) { return std::isfinite(n.all.sigma); });
  out.columns = {text_column("number"),
                 text_column("parameter"),
                 {"least … greatest mean"},
                 text_column("at"),
                 text_column("told from chance")};
  if (repeated) {
    out.columns.push_back({"least … greatest sigma"});
    out.columns.push_back(text_column("at"));
    out.columns.push_back(text_column("told from chance"));
  }
  for (std::size_t k = 0; k < drawn; ++k)
    for (std::size_t a = 0; a < std::min(table.axes.size(), kMostAxes); ++a) {
      const VariedAxis& axis = table.axes[a];
      if (table.scattered && axis.numeric) continue;
      auto levels = by_level(table, table.numbers[k], a);
      std::size_t known = 0;
      for (const GroupStatistics& g : levels) known += std::isfinite(g.mean);
      if (known < 2) continue;
      levels = by_level(table, table.numbers[k], a, SIZE_MAX, 0, coverage_of_extremes(known));
      std::vector<std::string> row = {with_unit(table.numbers[k].name, table.numbers[k].unit), axis.brief};
      const auto add = [&](const Extremes& e) {
        const bool any = e.low <= e.high;
        row.push_back(range_text(e.low, e.high));
        const bool differ = any && e.low < e.high;
        row.push_back(
            differ ? shortened(axis.names[e.low_at], 14) + " … " + shortened(axis.names[e.high_at], 14) : "");
        row.push_back(!any ? "" : !differ ? "no difference" : repeated ? verdict(e) : "not known: one seed");
      };
      add(extremes(levels, &GroupStatistics::mean, &GroupStatistics::mean_band));
      if (repeated) add(extremes(levels, &GroupStatistics::sigma, &GroupStatistics::sigma_band));
      out.add_row(row);
    }
  return out.rows.empty() ? "" : out.html();
}

std::string expected_table(const DesignTable& table, const TableNumber& n) {
  if (n.expected_mean.empty() && n.expected_sigma.empty()) return "";
  report::Table out;
  out.columns = {text_column("setting"), {"mean", n.unit},     {"expected", n.unit},  {"ratio"},
                 {"sigma", n.unit},      {"expected", n.unit}, {"ratio", "95 % band"}};
  double low = HUGE_VAL, high = 0.0;
  for (std::size_t s = 0; s < std::min(n.runs.size(), kMostSettings); ++s) {
    const GroupStatistics g = group_statistics({&n.runs[s]}, kReportCoverage);
    const double mean = n.expected_mean.empty() ? kNan : n.expected_mean[s],
                 sigma = n.expected_sigma.empty() ? kNan : n.expected_sigma[s];
    const double of_mean = n.is_error ? kNan : g.mean / mean;  // an error is expected to be about 0
    const double ratio = n.expected_sigma.empty() ? of_mean : g.sigma / sigma;
    if (std::isfinite(ratio)) low = std::min(low, ratio), high = std::max(high, ratio);
    const Interval band{g.sigma_band.low / sigma, g.sigma_band.high / sigma};
    out.add_row({setting_text(table, s), number(g.mean, 5), number(mean, 5),
                 n.is_error ? "" : report::fixed(of_mean, 3), number(g.sigma, 3), number(sigma, 3),
                 std::isfinite(g.sigma / sigma)
                     ? fmt::format("{:.3f} ({:.3f} … {:.3f})", g.sigma / sigma, band.low, band.high)
                     : "–"});
  }
  return fmt::format("<details><summary>Against what is expected{}</summary>{}</details>",
                     low <= high ? fmt::format(": {} is {:.3f} … {:.3f} times the expected",
                                               n.expected_sigma.empty() ? "the mean" : "sigma", low, high)
                                 : "",
                     out.html());
}

std::string settings_table(const DesignTable& table, std::size_t drawn) {
  report::Table out;
  out.columns = {text_column("setting"), {"runs"}};
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

}  // namespace fringetwin::study
