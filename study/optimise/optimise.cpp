// SPDX-License-Identifier: Apache-2.0
#include "study/optimise/optimise.hpp"

#include <algorithm>
#include <cmath>

#include "study/plan/space_filling.hpp"
#include "study/plan/study_tables.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/pareto_front.hpp"

namespace fringetwin::study {
namespace {

constexpr const char* kTime = "acquisition.time_s";

Settings chosen(const OptimisePlan& plan, const Place& place) {
  Settings out;
  for (std::size_t d = 0; d < place.size(); ++d) assign_at(plan.choose[d], place[d], &out);
  return out;
}

/// Adds all trials of one evaluation.
void add_points(const OptimisePlan& plan, std::size_t evaluation, const Settings& values,
                std::vector<StudyPoint>* points) {
  const UncertainInputs inputs = about(plan.inputs, plan.twin, values);
  for (std::size_t t = 0; t < plan.trials; ++t)
    points->push_back(point_of(inputs, static_cast<std::int64_t>(evaluation * plan.trials + t),
                               draw_inputs(inputs, plan.seed, DrawStream::trials, t), values));
}

/// Returns the results that must be numbers in every trial.
std::vector<std::string> needed(const OptimisePlan& plan) {
  std::vector<std::string> out = {plan.result};
  for (const Constraint& c : plan.constraints) out.push_back(c.result);
  return out;
}

Evaluation evaluation_of(const OptimisePlan& plan, Settings values,
                         const std::vector<const PointOutcome*>& trials) {
  Evaluation out;
  out.values = std::move(values);
  const auto fail = [&](const std::string& reason) {
    ++out.failed;
    if (out.reason.empty()) out.reason = reason;
  };
  std::map<std::string, std::vector<double>> sample;
  for (const PointOutcome* o : trials) {
    if (o == nullptr || o->failed) {
      fail(o == nullptr ? "was not run" : o->reason);
      continue;
    }
    bool whole = true;
    for (const std::string& name : needed(plan)) {
      if (std::isfinite(o->number(name)) || !whole) continue;
      fail("there is no " + name);
      whole = false;
    }
    if (!whole) continue;
    for (const auto& [name, value] : o->numbers) sample[name].push_back(value);
  }
  out.objective = statistic_of(sample[plan.result], plan.statistic, plan.value);
  for (const Constraint& c : plan.constraints)
    out.constraints.push_back(statistic_of(sample[c.result], Statistic::mean));
  out.time_s = statistic_of(sample[kTime], Statistic::mean).value;
  return out;
}

Assessment assessment_of(const OptimisePlan& plan, const Evaluation& e) {
  Assessment out;
  if (e.failed == 0) out.objective = e.objective.value;
  for (std::size_t k = 0; k < plan.constraints.size(); ++k) {
    const Constraint& c = plan.constraints[k];
    if (c.min) out.excess.push_back(*c.min - e.constraints[k].value);
    if (c.max) out.excess.push_back(e.constraints[k].value - *c.max);
  }
  return out;
}

SearchPlan search_plan(const OptimisePlan& plan) {
  SearchPlan out;
  for (const Variation& v : plan.choose) out.values.push_back(v.range ? 0 : v.values.size());
  for (const Constraint& c : plan.constraints)
    out.constraints += (c.min ? std::size_t{1} : 0) + (c.max ? std::size_t{1} : 0);
  out.evaluations = plan.evaluations;
  out.seed = plan.seed;
  return out;
}

}  // namespace

StatisticValue statistic_of(const std::vector<double>& trials, Statistic statistic, double value) {
  if (trials.size() < 2) return {kNan, kNan};
  const auto n = static_cast<double>(trials.size());
  const auto mean_and_sigma = [&](auto of) {
    double mean = 0.0, square = 0.0;
    for (const double x : trials) mean += of(x) / n;
    for (const double x : trials) square += std::pow(of(x) - mean, 2);
    return std::pair{mean, std::sqrt(square / (n - 1.0))};
  };
  const auto [mean, sigma] = mean_and_sigma([](double x) { return x; });
  if (statistic == Statistic::mean) return {mean, sigma / std::sqrt(n)};
  if (statistic == Statistic::sigma) return {sigma, sigma / std::sqrt(2.0 * (n - 1.0))};
  const auto [square, spread] = mean_and_sigma([&](double x) { return (x - value) * (x - value); });
  const double rms = std::sqrt(square);
  return {rms, rms > 0.0 ? spread / std::sqrt(n) / (2.0 * rms) : 0.0};
}

std::vector<Record> optimise_records(const OptimisePlan& plan) {
  std::vector<std::string> names = needed(plan);
  names.emplace_back(kTime);
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::vector<Record> out;
  for (const std::string& name : names) out.push_back({name, name});
  return out;
}

std::vector<StudyPoint> optimise_samples(const OptimisePlan& plan) {
  const UncertainInputs& inputs = plan.inputs;
  std::vector<StudyPoint> out(1);
  out.push_back(point_of(inputs, 1, draw_inputs(inputs, plan.seed, DrawStream::trials, 0)));
  for (const Variation& v : plan.choose) {
    const std::size_t n = v.range ? 2 : v.values.size();
    for (std::size_t i = 0; i < n; ++i) {
      out.push_back({static_cast<std::int64_t>(out.size()), {}, 0});
      assign_at(v, v.range ? static_cast<double>(i) : middle_of_share(i, n), &out.back().settings);
    }
  }
  return out;
}

OptimiseResult run_optimise(const OptimisePlan& plan, const RunPoints& run) {
  OptimiseResult out;
  const SearchResult found =
      search(search_plan(plan), [&](const std::vector<Place>& places, std::size_t first) {
        std::vector<StudyPoint> points;
        std::vector<Settings> values;
        for (const Place& place : places) {
          values.push_back(chosen(plan, place));
          add_points(plan, first + values.size() - 1, values.back(), &points);
        }
        const std::vector<PointOutcome> outcomes = run(points);
        std::map<std::int64_t, const PointOutcome*> by_id;
        for (const PointOutcome& o : outcomes) by_id[o.id] = &o;
        std::vector<Assessment> answers;
        for (std::size_t i = 0; i < places.size(); ++i) {
          std::vector<const PointOutcome*> trials;
          for (std::size_t t = 0; t < plan.trials; ++t) {
            const auto at = by_id.find(static_cast<std::int64_t>((first + i) * plan.trials + t));
            trials.push_back(at == by_id.end() ? nullptr : at->second);
          }
          out.evaluations.push_back(evaluation_of(plan, std::move(values[i]), trials));
          answers.push_back(assessment_of(plan, out.evaluations.back()));
          out.evaluations.back().feasible = answers.back().feasible();
        }
        return answers;
      });
  out.best = found.best;
  std::vector<CostAndError> costs;
  for (std::size_t i = 0; i < out.evaluations.size(); ++i) {
    Evaluation& e = out.evaluations[i];
    e.phase = found.tried[i].phase;
    costs.push_back({e.feasible ? e.time_s : kNan, e.objective.value});
  }
  out.front = pareto_front(costs);
  return out;
}

}  // namespace fringetwin::study
