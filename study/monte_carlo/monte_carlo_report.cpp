// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "report/table.hpp"
#include "report/text.hpp"
#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/page/report_parts.hpp"
#include "study/plan/recorded_numbers.hpp"

namespace fringetwin::study {
namespace {

using report::number, report::Plot, report::Series, report::text_column;

constexpr std::size_t kMostNumbers = 12;

/// A quantity with its trials, as the page draws it.
struct Quantity {
  std::string name, unit;
  const MonteCarloNumber& number;
  std::vector<double> trials;  ///< NaN where there is none
};

std::vector<Quantity> quantities(const StudyRecord& study, const MonteCarloResult& result) {
  std::vector<Quantity> out;
  for (const auto& [name, n] : result.numbers) {
    std::string path = name;
    for (const Record& r : study.head.records)
      if (r.name == name) path = r.result;
    out.push_back({name, unit_of(path), n, std::vector<double>(result.trials, kNan)});
  }
  for (const StoredPoint& row : study.rows) {
    if (row.status != PointStatus::done || static_cast<std::size_t>(row.point.id) >= result.trials) continue;
    for (Quantity& q : out)
      if (const auto value = row.outcome.numbers.find(q.name); value != row.outcome.numbers.end())
        q.trials[row.point.id] = value->second;
  }
  return out;
}

Series upright(double x, double top, const std::string& title, const char* color, Series::Style style) {
  return {.title = title, .x = {x, x}, .y = {0.0, top}, .style = style, .color = color, .width = 1.8};
}

/// Values are drawn as deviations from the mean: their differences are what is of interest.
Plot histogram_plot(const Quantity& q, double coverage) {
  const SampleSummary& s = q.number.summary;
  Plot plot{.title = fmt::format("trials of {}, mean {}{}", shortened(q.name, 48), number(s.mean, 8),
                                 q.unit.empty() ? "" : " " + q.unit),
            .x_label = with_unit("difference from the mean", q.unit),
            .y_label = "trials [%]",
            .width_px = 980,
            .height_px = 360};
  std::vector<float> values;
  double low = 0.0, high = 0.0;
  for (const double v : q.trials) {
    if (std::isnan(v)) continue;
    values.push_back(static_cast<float>(v - s.mean));
    low = std::min(low, v - s.mean);
    high = std::max(high, v - s.mean);
  }
  const int bins = std::clamp(static_cast<int>(2.0 * std::cbrt(static_cast<double>(s.n))), 6, 60);
  const double margin = 1e-3 * (high - low);
  const report::Histogram h = report::histogram(values, bins, low - margin, high + margin);
  const Series bars = report::histogram_series(h, "trials", "#7fb2d0");
  Series normal{.title = "normal of this mean and sigma",
                .style = Series::Style::line,
                .color = report::color::kDifference,
                .width = 1.4};
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = 1.1 * (low + (high - low) * i / kSteps);
    normal.add(x, 100.0 * h.bin_width * std::exp(-0.5 * x * x / (s.sigma * s.sigma)) /
                      (s.sigma * std::sqrt(2.0 * std::numbers::pi)));
  }
  double top = *std::ranges::max_element(bars.y);
  top = 1.08 * std::max(top, *std::ranges::max_element(normal.y));
  const auto line = [&](double x, const std::string& title, const char* color, Series::Style style) {
    plot.series.push_back(upright(x - s.mean, top, title, color, style));
  };
  plot.series = {bars, normal};
  line(s.mean, "mean", report::color::kReal, Series::Style::line);
  const std::string percent = fmt::format("{:g} %, ", 100.0 * coverage);
  line(s.symmetric.low, percent + "symmetric", report::color::kSimulated, Series::Style::line);
  line(s.symmetric.high, "", report::color::kSimulated, Series::Style::line);
  line(s.shortest.low, percent + "shortest", report::color::kThird, Series::Style::dashed);
  line(s.shortest.high, "", report::color::kThird, Series::Style::dashed);
  plot.y_range = {0.0, top};
  plot.x_range = {1.1 * low, 1.1 * high};
  return plot;
}

/// Returns a plot of the estimate with twice its standard deviation, and the tolerance around the last.
Plot estimate_plot(const Quantity& q, const std::vector<ConvergenceStep>& steps, const std::string& what,
                   double ConvergenceStep::*value, double Convergence::*error) {
  Plot plot{
      .title = what + " of " + shortened(q.name, 40), .x_label = "trials", .width_px = 540, .height_px = 330};
  const double last = steps.back().*value, tolerance = steps.back().convergence.tolerance;
  const bool from_last = value == &ConvergenceStep::mean;
  plot.y_label = with_unit(from_last ? "mean - last mean" : what, q.unit);
  const double origin = from_last ? last : 0.0;
  Series band{
      .title = "± twice its standard deviation", .style = Series::Style::band, .color = report::color::kReal};
  Series line{.title = what, .style = Series::Style::line, .color = report::color::kReal, .width = 1.8};
  for (const ConvergenceStep& s : steps) {
    const auto x = static_cast<double>(s.trials);
    const double y = s.*value - origin, half = s.convergence.*error;
    line.add(x, y);
    band.add(x, y + half);
    band.y_low.push_back(y - half);
  }
  plot.series = {band, line};
  for (const double sign : {-1.0, 1.0})
    plot.series.push_back({.title = sign < 0 ? "tolerance" : "",
                           .x = {line.x.front(), line.x.back()},
                           .y = std::vector<double>(2, last - origin + sign * tolerance),
                           .style = Series::Style::dashed,
                           .color = report::color::kSimulated});
  return plot;
}

/// Returns the factors in the order of their total effects, the greatest last.
std::vector<std::size_t> by_total(const SobolIndices& s) {
  std::vector<std::size_t> order(s.total.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return s.total[a].value < s.total[b].value; });
  return order;
}

/// Returns the plot of the effects of the factors, the largest total effect at the top.
Plot tornado_plot(const Quantity& q, const std::vector<std::string>& factors, double coverage) {
  const SobolIndices& s = q.number.sensitivity;
  const std::vector<std::size_t> order = by_total(s);
  Plot plot{.title = "where the variance of " + shortened(q.name, 48) + " comes from",
            .x_label = fmt::format("share of the variance (whiskers: {:g} %)", 100.0 * coverage),
            .zero_line = true,
            .width_px = 980,
            .height_px = 110 + 50 * static_cast<int>(order.size())};
  const auto side = [&](const char* title, const char* color, const std::vector<SobolIndex>& values,
                        double shift) {
    Series bars{.title = title, .style = Series::Style::bars_across, .color = color};
    Series whiskers = bars;
    whiskers.title = "";
    whiskers.style = Series::Style::whiskers_across;
    whiskers.color = report::color::kDifference;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const SobolIndex& v = values[order[i]];
      bars.add(v.value, static_cast<double>(i) + shift);
      whiskers.x_low.push_back(v.interval.low);
      whiskers.x_high.push_back(v.interval.high);
    }
    whiskers.x = bars.x;
    whiskers.y = bars.y;
    plot.series.push_back(bars);
    plot.series.push_back(whiskers);
  };
  side("total: any part in", report::color::kReal, s.total, 0.18);
  side("first-order: alone", "#E69F00", s.first, -0.18);
  double low = 0.0, high = 1.0;
  for (const auto* values : {&s.first, &s.total})
    for (const SobolIndex& v : *values)
      if (std::isfinite(v.interval.low))
        low = std::min(low, v.interval.low), high = std::max(high, v.interval.high);
  plot.x_range = {1.02 * low, 1.02 * high};
  plot.y_range = {-0.6, static_cast<double>(order.size()) - 0.4};
  for (std::size_t i = 0; i < order.size(); ++i)
    plot.y_tics.emplace_back(static_cast<double>(i), shortened(factors[order[i]], 30));
  return plot;
}

/// Returns the decimals that the tolerance justifies, and one more.
int decimals_for(const MonteCarloNumber& n) {
  const double step = n.convergence.tolerance > 0.0 ? n.convergence.tolerance : 0.1 * n.summary.sigma;
  return step > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(step))), 0, 15) : 6;
}

std::string quantities_table(const std::vector<Quantity>& all, const MonteCarloPlan& plan) {
  const std::string percent = fmt::format("{:g} %", 100.0 * plan.rule.coverage);
  report::Table out;
  out.columns = {text_column("number"),
                 {"trials"},
                 {"mean"},
                 {"sigma", "standard uncertainty"},
                 {"symmetric interval", percent},
                 {"shortest interval", percent},
                 {"worst / tolerance", "twice its deviation"},
                 text_column("enough")};
  for (const Quantity& q : all) {
    const SampleSummary& s = q.number.summary;
    const Convergence& c = q.number.convergence;
    const int decimals = decimals_for(q.number);
    const auto interval = [&](const Interval& i) {
      return report::fixed(i.low, decimals) + " … " + report::fixed(i.high, decimals);
    };
    out.add_row({with_unit(q.name, q.unit), std::to_string(s.n), report::fixed(s.mean, decimals),
                 number(s.sigma, 3), interval(s.symmetric), interval(s.shortest),
                 number(std::max({c.mean, c.sigma, c.low, c.high}), 2) + " / " + number(c.tolerance, 2),
                 c.reached ? "yes" : "no"},
                c.reached ? "pass" : "fail");
  }
  return out.html();
}

std::string shares_table(const std::vector<Quantity>& all, const MonteCarloResult& result) {
  report::Table out;
  out.caption = "Shares of the variance; the greatest total effect first.";
  out.columns = {text_column("number"),
                 text_column("factor"),
                 {"total effect", "any part in"},
                 {"its interval"},
                 {"first-order", "alone"},
                 {"its interval"},
                 {"rows"}};
  const auto interval = [](const Interval& i) {
    return report::fixed(i.low, 3) + " … " + report::fixed(i.high, 3);
  };
  for (const Quantity& q : all) {
    const SobolIndices& s = q.number.sensitivity;
    std::vector<std::size_t> order = by_total(s);
    std::ranges::reverse(order);
    for (const std::size_t f : order)
      out.add_row({f == order[0] ? q.name : "", result.factors[f], report::fixed(s.total[f].value, 3),
                   interval(s.total[f].interval), report::fixed(s.first[f].value, 3),
                   interval(s.first[f].interval), std::to_string(s.rows)});
  }
  return out.html();
}

std::string note_of(const MonteCarloPlan& plan, const MonteCarloResult& result) {
  std::string out = fmt::format(
      "{} after {} trials: mean, sigma and both ends of the symmetric interval of every number are {}known "
      "to {} significant digit{} of sigma (JCGM 101, 7.9; blocks of {} trials). ",
      result.converged ? "Enough" : "NOT enough", result.trials, result.converged ? "" : "not all ",
      plan.rule.digits, plan.rule.digits == 1 ? "" : "s", plan.rule.trials_per_block());
  if (plan.rule.trials_per_block() < 10'000)
    out += "The standard's blocks have 10,000 trials: smaller ones make the rule easier to meet by chance. ";
  if (plan.sensitivity_rows > 0)
    out += fmt::format("Sensitivities from {} rows: a factor whose interval reaches 0 may have no effect. ",
                       plan.sensitivity_rows);
  return out + "What is not among the inputs above is not in the uncertainty.";
}

}  // namespace

StudyReport monte_carlo_report(const StudyRecord& study, const MonteCarloPlan& plan,
                               const MonteCarloResult& result) {
  const std::vector<Quantity> all = quantities(study, result);
  FigureSheet sheet;
  report::Page page =
      page_of(study, fmt::format("Monte Carlo: {} trials, {} failed, on the twin {}", result.trials,
                                 result.failed, study.head.twin.filename().string()));
  page.verdict = result.converged ? "converged" : "not converged";
  page.summary_html = quantities_table(all, plan) + inputs_table(plan.inputs) + page.summary_html;
  page.note = note_of(plan, result);
  add_failures(study, &page);
  if (plan.sensitivity_rows > 0)
    page.sections.push_back({"sensitivity", "Sensitivities", shares_table(all, result)});
  for (std::size_t k = 0; k < std::min(all.size(), kMostNumbers); ++k) {
    const Quantity& q = all[k];
    std::string body;
    if (std::isnan(q.number.summary.sigma)) {
      body = fmt::format("<p>No scatter to draw: {} of {} trials have this number.</p>", q.number.summary.n,
                         result.trials);
    } else if (q.number.summary.sigma == 0.0) {
      body = "<p>The same in all trials.</p>";
    } else {
      body += report::figure_html(sheet.place(q.name + "-histogram", histogram_plot(q, plan.rule.coverage)),
                                  "All trials. Where the bars do not follow the normal curve, mean ± k sigma "
                                  "is no coverage interval; those drawn are.");
      const std::vector<ConvergenceStep> steps = convergence_steps(q.trials, plan.rule);
      if (!steps.empty())
        body += report::figure_html(
            FigureSheet::row(
                {sheet.place(q.name + "-mean",
                             estimate_plot(q, steps, "mean", &ConvergenceStep::mean, &Convergence::mean)),
                 sheet.place(q.name + "-sigma", estimate_plot(q, steps, "sigma", &ConvergenceStep::sigma,
                                                              &Convergence::sigma))}),
            "After so many trials. The rule asks the band to be no wider than the tolerance, here and at the "
            "ends of the interval.",
            "twice s(block averages)/√blocks ≤ δ");
      if (plan.sensitivity_rows > 0 && std::isfinite(q.number.sensitivity.variance) &&
          !result.factors.empty())
        body += report::figure_html(
            sheet.place(q.name + "-tornado", tornado_plot(q, result.factors, plan.rule.coverage)),
            "First-order: the share that goes with the factor alone; total: in which it has any part. Values "
            "below 0 or above 1 are chance.",
            "S_i = cov(f(B), f(A_i) - f(A))/V,  T_i = mean((f(A) - f(A_i))²)/2V");
    }
    page.sections.push_back({"number-" + std::to_string(k), q.name, body});
  }
  if (all.size() > kMostNumbers)
    page.warnings.push_back("Of the numbers " + shown_of(kMostNumbers, all.size()) +
                            " are drawn, all are in the table.");
  return sheet.finish(page.html());
}

}  // namespace fringetwin::study
