// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/table.hpp"
#include "report/text.hpp"
#include "study/optimise/optimise.hpp"
#include "study/page/pareto_plot.hpp"
#include "study/page/report_parts.hpp"
#include "study/page/varied_axes.hpp"
#include "study/plan/recorded_numbers.hpp"

namespace fringetwin::study {
namespace {

using report::number, report::Plot, report::Series, report::text_column;

constexpr std::size_t kMostBest = 20;

std::string objective_name(const OptimisePlan& plan) {
  const char* statistic = plan.statistic == Statistic::sigma  ? "sigma"
                          : plan.statistic == Statistic::mean ? "mean"
                                                              : "rms error";
  return fmt::format("{} of {}", statistic, display_name(plan.result));
}

/// The evaluations as three series of points: feasible, not feasible, best.
struct Marks {
  Series feasible{
      .title = "feasible", .style = Series::Style::points, .color = report::color::kReal, .width = 2.0};
  Series others{.title = "constraints not met",
                .style = Series::Style::points,
                .color = report::color::kSimulated,
                .width = 2.0,
                .point_type = 6};
  Series best{.title = "best",
              .style = Series::Style::points,
              .color = report::color::kDifference,
              .width = 5.0,
              .point_type = 12};
  void add_to(Plot* plot) const {
    for (const Series* s : {&others, &feasible, &best}) plot->series.push_back(*s);
  }
};
/// Returns the points with the given `x` of each evaluation.
Marks marks(const OptimiseResult& result, const std::vector<double>& x) {
  Marks out;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Evaluation& e = result.evaluations[i];
    Series& s = e.feasible ? out.feasible : out.others;
    s.add(x[i], e.objective.value);
    if (result.best != i) continue;
    out.best.add(x[i], e.objective.value);
  }
  return out;
}

std::vector<double> objectives(const OptimiseResult& result) {
  std::vector<double> out;
  for (const Evaluation& e : result.evaluations) out.push_back(e.objective.value);
  return out;
}

Plot progress_plot(const OptimisePlan& plan, const OptimiseResult& result) {
  Plot plot{.title = objective_name(plan) + ", evaluation by evaluation",
            .x_label = "evaluation",
            .y_label = with_unit("objective", unit_of(plan.result)),
            .width_px = 980,
            .height_px = 380};
  std::vector<double> at;
  Series so_far{.title = "least feasible so far",
                .style = Series::Style::line,
                .color = report::color::kThird,
                .width = 1.8};
  double least = kNan;
  for (std::size_t i = 0; i < result.evaluations.size(); ++i) {
    const Evaluation& e = result.evaluations[i];
    at.push_back(static_cast<double>(i + 1));
    if (!std::isnan(least)) so_far.add(at.back(), least);
    if (!e.feasible || !(std::isnan(least) || e.objective.value < least)) continue;
    least = e.objective.value;
    so_far.add(at.back(), least);
  }
  Marks all = marks(result, at);
  // feasible ones with their standard error
  Series& feasible = all.feasible;
  feasible.style = Series::Style::whiskers;
  feasible.title = "feasible, ± standard error";
  for (const Evaluation& e : result.evaluations)
    if (e.feasible) {
      feasible.y_low.push_back(e.objective.value - e.objective.sigma);
      feasible.y_high.push_back(e.objective.value + e.objective.sigma);
    }
  std::vector<double> heights = objectives(result);
  heights.insert(heights.end(), feasible.y_low.begin(), feasible.y_low.end());
  plot.log_y = spans_a_decade(heights);
  plot.series = {so_far};
  all.add_to(&plot);
  plot.x_range = {0.0, at.empty() ? 1.0 : at.back() + 1.0};
  return plot;
}

Plot parameter_plot(const OptimisePlan& plan, const OptimiseResult& result, const VariedSettings& varied,
                    std::size_t axis) {
  std::vector<double> x;
  for (const Setting& s : varied.settings) x.push_back(varied.axes[axis].values[s.level[axis]]);
  Plot plot = axis_plot(varied.axes[axis]);
  plot.title = shortened(objective_name(plan), 60);
  plot.y_label = with_unit("objective", unit_of(plan.result));
  plot.log_y = spans_a_decade(objectives(result));
  marks(result, x).add_to(&plot);
  return plot;
}

std::string limits_text(const Constraint& c) {
  std::string out;
  if (c.min) out += fmt::format("≥ {:.6g}", *c.min);
  if (c.max) out += fmt::format("{}≤ {:.6g}", out.empty() ? "" : ", ", *c.max);
  return out;
}

std::string interval_text(const StatisticValue& v) {
  return number(v.interval.low, 3) + " … " + number(v.interval.high, 3);
}

/// Returns the table of the evaluations in the order of `shown`; `marked`: those of the front, by what is
/// known best of them.
std::string evaluations_table(const OptimisePlan& plan, const OptimiseResult& result,
                              const VariedSettings& varied, const std::vector<std::size_t>& shown,
                              bool marked) {
  report::Table out;
  out.columns = {text_column(marked ? "" : "evaluation"),
                 {"objective", marked ? "95 % interval" : "± standard error"},
                 {"time", "s"}};
  for (const Constraint& c : plan.constraints)
    out.columns.push_back({shortened(display_name(c.result)), limits_text(c)});
  for (const VariedAxis& axis : varied.axes) out.columns.push_back({axis.brief});
  out.columns.push_back(text_column("phase"));
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const Evaluation& e = marked ? result.last_of(shown[k]) : result.evaluations[shown[k]];
    std::vector<std::string> row = {
        marked ? front_mark(k) : std::to_string(shown[k] + 1),
        marked ? number(e.objective.value, 3) + " (" + interval_text(e.objective) + ")"
               : number(e.objective.value, 4) + " ± " + number(e.objective.sigma, 2),
        number(e.time_s)};
    for (const StatisticValue& c : e.constraints) row.push_back(number(c.value) + " ± " + number(c.sigma, 2));
    row.resize(3 + plan.constraints.size());
    for (std::size_t a = 0; a < varied.axes.size(); ++a)
      row.push_back(varied.axes[a].names[varied.settings[shown[k]].level[a]]);
    row.push_back(result.evaluations[shown[k]].phase);
    out.add_row(row, result.best == shown[k] ? "group" : "");
  }
  return out.html();
}

/// Returns the table of the best, measured again: which of them chance alone could have put first.
std::string candidates_table(const OptimisePlan& plan, const OptimiseResult& result,
                             const VariedSettings& varied) {
  report::Table out;
  out.caption = fmt::format(
      "The best of the search, each measured again with the same {} fresh draws. The least of them was "
      "measured once more with {} others, which no choice has seen: that is its value.",
      kFreshTrials * plan.trials, kFreshTrials * plan.trials);
  out.columns = {text_column("evaluation"),
                 {"in the search"},
                 {"again", "95 % interval"},
                 {"time", "s"},
                 text_column("against the best")};
  for (const VariedAxis& axis : varied.axes) out.columns.push_back({axis.brief});
  for (const Candidate& c : result.candidates) {
    const bool best = result.best == c.evaluation;
    const StatisticValue& again = result.last_of(c.evaluation).objective;
    std::string against = c.told_apart ? "worse" : "not told apart";
    if (!c.fresh.feasible) against = "constraints not met";
    if (best) against = "the best";
    if (result.recommended == c.evaluation) against += ", recommended";
    std::vector<std::string> row = {
        std::to_string(c.evaluation + 1), number(result.evaluations[c.evaluation].objective.value, 3),
        number(again.value, 3) + " (" + interval_text(again) + ")", number(c.fresh.time_s), against};
    for (const VariedAxis& axis : varied.axes)
      row.push_back(axis.names[varied.settings[c.evaluation]
                                   .level[static_cast<std::size_t>(&axis - varied.axes.data())]]);
    out.add_row(row, best ? "group" : "");
  }
  return out.html();
}

/// Returns a feasible evaluation's whiskers against time: two points are told apart where the front says so.
Series bands(const OptimiseResult& result) {
  Series out{.title = "95 % intervals",
             .style = Series::Style::whiskers,
             .color = report::color::kReal,
             .width = 1.0};
  for (std::size_t i = 0; i < result.evaluations.size(); ++i) {
    const Evaluation& e = result.last_of(i);
    if (!result.is_feasible(i) || std::isnan(e.time_s) || std::isnan(e.objective.interval.low)) continue;
    out.add(e.time_s, e.objective.value);
    out.y_low.push_back(e.objective.interval.low);
    out.y_high.push_back(e.objective.interval.high);
  }
  return out;
}

/// Returns the feasible evaluations by rising objective.
std::vector<std::size_t> best_first(const OptimiseResult& result) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < result.evaluations.size(); ++i)
    if (result.evaluations[i].feasible) out.push_back(i);
  std::ranges::stable_sort(out, [&](std::size_t a, std::size_t b) {
    return result.evaluations[a].objective.value < result.evaluations[b].objective.value;
  });
  return out;
}

std::string among_text(const Variation& v) {
  if (v.range)
    return fmt::format("{:.6g} … {:.6g}{}", v.range->first, v.range->last, v.range->log ? ", log" : "");
  return v.values.size() == 1 ? "fixed" : fmt::format("{} values", v.values.size());
}

std::string choice_table(const OptimisePlan& plan, const OptimiseResult& result) {
  report::Table out;
  out.caption = "What could be chosen: nothing that was tried meets all constraints.";
  if (result.chosen)
    out.caption = fmt::format("What was chosen: {} {} (95 % interval {}, {} trials that chose nothing).",
                              objective_name(plan), number(result.chosen->objective.value, 3),
                              interval_text(result.chosen->objective), result.chosen->objective.n);
  out.columns = {text_column("key"), {"best"}, text_column("among")};
  for (const Variation& v : plan.choose)
    for (std::size_t k = 0; k < v.keys.size(); ++k) {
      const std::string among = among_text(v);
      const auto value =
          result.best ? result.evaluations[*result.best].values.find(v.keys[k]) : Settings::const_iterator();
      const bool known = result.best && value != result.evaluations[*result.best].values.end();
      out.add_row({v.keys[k], known ? shortened(level_name(value->second)) : "–", among});
    }
  return out.html();
}

std::string note_of(const OptimisePlan& plan, const OptimiseResult& result) {
  std::size_t feasible = 0, failed = 0;
  for (const Evaluation& e : result.evaluations) {
    feasible += e.feasible ? 1 : 0;
    failed += e.failed > 0 ? 1 : 0;
  }
  std::string out = fmt::format(
      "{} of {} evaluations meet all constraints, {} failed. Each has the same {} draws, and the least of "
      "many is too small by chance: the value of the best is that of its own fresh trials. What is not told "
      "apart from it may be as good. A search within a budget need not find the least there is; means are "
      "held against the constraints without a margin.",
      feasible, result.evaluations.size(), failed, plan.trials);
  if (result.screened > 0)
    out += fmt::format(" {} settings were put in order by their closed form, without measurements.",
                       result.screened);
  if (result.left_out > 0)
    out += fmt::format(" {} settings are no valid twin and were left out: {}", result.left_out,
                       result.left_out_reason);
  return out;
}

}  // namespace

StudyReport optimise_report(const StudyRecord& study, const OptimisePlan& plan,
                            const OptimiseResult& result) {
  VariedSettings varied;
  varied.settings.resize(result.evaluations.size());
  std::vector<const Settings*> settings;
  for (const Evaluation& e : result.evaluations) settings.push_back(&e.values);
  if (!settings.empty()) add_axes(plan.choose, settings, &varied);

  FigureSheet sheet;
  report::Page page = page_of(
      study, fmt::format("Least {}: {} evaluations of {} trials, on the twin {}", objective_name(plan),
                         result.evaluations.size(), plan.trials, study.head.twin.filename().string()));
  page.verdict = result.best ? "" : "not feasible";
  page.summary_html = choice_table(plan, result) + inputs_table(plan.inputs) + page.summary_html;
  page.note = note_of(plan, result);
  std::vector<std::size_t> best = best_first(result);
  const std::string shown = shown_of(kMostBest, best.size());
  best.resize(std::min(best.size(), kMostBest));
  page.sections.push_back({"search", "Search",
                           report::figure_html(sheet.place("progress", progress_plot(plan, result)),
                                               "Failed evaluations are not drawn.")});
  if (!result.candidates.empty())
    page.sections.push_back({"again", "The best again", candidates_table(plan, result, varied)});
  if (!best.empty())
    page.sections.push_back(
        {"best", "Best evaluations",
         (shown.empty() ? "" : "<p>Of the feasible ones " + shown + "; all are in result.json.</p>") +
             evaluations_table(plan, result, varied, best, false)});
  if (!result.front.empty()) {
    std::vector<CostAndError> points;
    for (std::size_t i = 0; i < result.evaluations.size(); ++i) {
      const Evaluation& e = result.last_of(i);
      const bool feasible = result.is_feasible(i);
      points.push_back({feasible ? e.time_s : kNan, feasible ? e.objective.value : kNan});
    }
    Plot plot = front_plot(points, result.front, "feasible evaluations");
    plot.series.push_back(bands(result));
    plot.title = objective_name(plan) + " against time";
    plot.y_label = with_unit("objective", unit_of(plan.result));
    page.sections.push_back(
        {"front", "Time against uncertainty",
         report::figure_html(
             sheet.place("front", plot),
             "A slower setting is on the front where it is better than every quicker one by more "
             "than chance. Steps: between two points of the front the cheaper one is what can "
             "be had.") +
             evaluations_table(plan, result, varied, result.front, true)});
  }
  std::string parameters;
  for (std::size_t a = 0; a < std::min(varied.axes.size(), kMostAxes); a += 2) {
    std::vector<std::string> row;
    for (std::size_t k = a; k < std::min(a + 2, varied.axes.size()); ++k)
      row.push_back(
          sheet.place("objective-" + varied.axes[k].brief, parameter_plot(plan, result, varied, k)));
    parameters +=
        report::figure_html(FigureSheet::row(row), "All evaluations: the other parameters differ, too.");
  }
  if (!parameters.empty()) page.sections.push_back({"parameters", "Parameters", parameters});
  add_failures(study, &page);
  return sheet.finish(page.html());
}

}  // namespace fringetwin::study
