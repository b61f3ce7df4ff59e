// SPDX-License-Identifier: Apache-2.0
#include "study/kind/kept_points.hpp"

#include <fmt/format.h>

#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

/// Returns the outcomes of these points that the store has.
std::vector<PointOutcome> stored(const StudyStore& store, const PointSequence& points) {
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

KeptPoints::Planned KeptPoints::plan(const PointSequence& points) {
  store_.add(points);
  Planned out{plan_traces(task_.twin, points), {}};
  for (const PlannedPoint& planned : out.points) out.done.insert(planned.point.id);
  for (const StudyPoint& point : store_.pending()) out.done.erase(point.id);
  return out;
}

void KeptPoints::run(const Planned& planned) {
  summary_.add(engine_.run(task_, planned.points, planned.done, [&](const PointOutcome& outcome) {
    store_.record({outcome});
    tell_first_gate_warnings(outcome);
  }));
}

// The engine hands over outcomes one by one, in this thread, wherever the points ran.
void KeptPoints::tell_first_gate_warnings(const PointOutcome& outcome) {
  if (outcome.gate_warnings.empty() || ++with_gate_warnings_ > 1) return;
  for (const std::string& sentence : outcome.gate_warnings)
    warn(fmt::format("point {}: {}", outcome.id, sentence));
}

void KeptPoints::tell_later_gate_warnings() const {
  if (with_gate_warnings_ < 2) return;
  warn(fmt::format(
      "{} more of the points of this run {} such warnings: record fits.NAME.measured.n_gated to see "
      "how many points "
      "each fit had",
      with_gate_warnings_ - 1, with_gate_warnings_ == 2 ? "has" : "have"));
}

std::vector<PointOutcome> KeptPoints::run(
    const PointSequence& points, const Outlook& outlook,
    const std::function<void(const std::vector<StudyPoint>&)>& announce) {
  store_.add(points);
  std::vector<PointOutcome> outcomes = stored(store_, points);
  if (outcomes.size() == points.size()) return outcomes;
  std::set<std::int64_t> done;
  for (const PointOutcome& outcome : outcomes) done.insert(outcome.id);
  if (announce) {
    std::vector<StudyPoint> missing;
    for (const StudyPoint& point : points)
      if (!done.contains(point.id)) missing.push_back(point);
    announce(missing);
  }
  engine_.expect({outlook.finished + done.size(), outlook.in_all});
  run(Planned{plan_traces(task_.twin, points), std::move(done)});
  return stored(store_, points);
}

}  // namespace fringetwin::study
