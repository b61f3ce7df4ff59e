// SPDX-License-Identifier: Apache-2.0
#include "study/engine/kept_points.hpp"

namespace fringetwin::study {
namespace {

/// Outcomes of these points, as the store has them.
std::vector<PointOutcome> stored(const StudyStore& store, const std::vector<StudyPoint>& points) {
  std::set<std::int64_t> ids;
  for (const StudyPoint& point : points) ids.insert(point.id);
  std::vector<PointOutcome> out;
  if (ids.empty()) return out;
  for (StoredPoint& row : store.rows(*ids.begin(), *ids.rbegin()))
    if (row.status != PointStatus::pending && ids.contains(row.point.id))
      out.push_back(std::move(row.outcome));
  return out;
}

}  // namespace

std::vector<PointOutcome> KeptPoints::run(const std::vector<StudyPoint>& points) {
  store_.add(points);
  std::vector<PointOutcome> outcomes = stored(store_, points);
  if (outcomes.size() == points.size()) return outcomes;
  std::set<std::int64_t> done;
  for (const PointOutcome& outcome : outcomes) done.insert(outcome.id);
  summary_.add(engine_.run(task_, plan_traces(task_.twin, points), done,
                           [&](const PointOutcome& outcome) { store_.record({outcome}); }));
  return stored(store_, points);
}

}  // namespace fringetwin::study
