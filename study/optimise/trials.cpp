// SPDX-License-Identifier: Apache-2.0
#include "study/optimise/trials.hpp"

#include <algorithm>
#include <cmath>

namespace fringetwin::study {
namespace {

/// Adds all trials of one setting.
void add_points(const OptimisePlan& plan, const Settings& values, const TrialBlock& block,
                std::vector<StudyPoint>* points) {
  const UncertainInputs inputs = about(plan.inputs, plan.twin, values);
  for (std::size_t t = 0; t < block.trials; ++t)
    points->push_back(point_of(inputs, block.first_id + static_cast<std::int64_t>(points->size()),
                               draw_inputs(inputs, plan.seed, DrawStream::trials, block.first_trial + t),
                               values));
}

Evaluation evaluation_of(const OptimisePlan& plan, const Settings& values,
                         const std::vector<const PointOutcome*>& trials) {
  Evaluation out;
  out.values = values;
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
    for (const std::string& name : needed_results(plan)) {
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
  out.time_s = statistic_of(sample[kTimeResult], Statistic::mean).value;
  out.feasible = assessment_of(plan, out).feasible();
  return out;
}

}  // namespace

std::vector<Evaluation> evaluate(const OptimisePlan& plan, const RunPoints& run,
                                 const std::vector<Settings>& values, const TrialBlock& block) {
  std::vector<StudyPoint> points;
  for (const Settings& v : values) add_points(plan, v, block, &points);
  const std::vector<PointOutcome> outcomes = run(points);
  std::map<std::int64_t, const PointOutcome*> by_id;
  for (const PointOutcome& o : outcomes) by_id[o.id] = &o;
  std::vector<Evaluation> out;
  auto point = points.begin();
  for (const Settings& v : values) {
    std::vector<const PointOutcome*> trials;
    for (std::size_t t = 0; t < block.trials; ++t, ++point) {
      const auto at = by_id.find(point->id);
      trials.push_back(at == by_id.end() ? nullptr : at->second);
    }
    out.push_back(evaluation_of(plan, v, trials));
  }
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

std::vector<std::string> needed_results(const OptimisePlan& plan) {
  std::vector<std::string> out = {plan.result};
  for (const Constraint& c : plan.constraints) out.push_back(c.result);
  return out;
}

}  // namespace fringetwin::study
