// SPDX-License-Identifier: Apache-2.0
#include "study/monte_carlo_local.hpp"

#include <set>

namespace fringetwin::study {
namespace {

/// Outcomes of these points, as the store has them.
std::vector<PointOutcome> stored(const StudyStore& store, const std::vector<StudyPoint>& points) {
  std::set<std::int64_t> ids;
  for (const StudyPoint& point : points) ids.insert(point.id);
  std::vector<PointOutcome> out;
  for (StoredPoint& row : store.rows())
    if (row.status != PointStatus::pending && ids.contains(row.point.id))
      out.push_back(std::move(row.outcome));
  return out;
}

}  // namespace

MonteCarloPlan complete_plan(const StudyFile& study) {
  MonteCarloPlan plan = study.monte_carlo.value().plan;
  if (study.monte_carlo->calibration)
    plan.inputs.calibration = VirtualRig(study.twin, true).calibration_directions();
  return plan;
}

StudyPoint first_trial(const StudyFile& study) {
  const MonteCarloPlan& plan = study.monte_carlo.value().plan;
  return point_of(plan.inputs, 0, draw_inputs(plan.inputs, plan.seed, DrawStream::trials, 0));
}

MonteCarloResult run_monte_carlo_local(const StudyFile& study, const MonteCarloPlan& plan, StudyStore& store,
                                       const LocalOptions& options, LocalSummary* summary) {
  const PointTask task{study.twin, study.records, true, plan.inputs.calibration > 0};
  return run_monte_carlo(plan, [&](const std::vector<StudyPoint>& points) {
    store.add(points);
    std::vector<PointOutcome> outcomes = stored(store, points);
    if (outcomes.size() == points.size()) return outcomes;
    std::set<std::int64_t> done;
    for (const PointOutcome& outcome : outcomes) done.insert(outcome.id);
    const LocalSummary batch = run_local(task, plan_traces(study.twin, points), done, options,
                                         [&](const PointOutcome& outcome) { store.record({outcome}); });
    summary->finished += batch.finished;
    summary->failed += batch.failed;
    summary->traced += batch.traced;
    return stored(store, points);
  });
}

}  // namespace fringetwin::study
