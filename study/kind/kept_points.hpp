// SPDX-License-Identifier: Apache-2.0
// Runs points by an engine and keeps their outcomes in the study's store, so that none is run twice.
#pragma once
#include <set>
#include <vector>

#include "study/engine/engine.hpp"
#include "study/store/study_store.hpp"

namespace fringetwin::study {

class KeptPoints {
 public:
  KeptPoints(PointTask task, Engine& engine, StudyStore& store)
      : task_(std::move(task)), engine_(engine), store_(store) {
    task_.study = store.digest();
  }

  /// Points with their traces, and which of them the store has finished.
  struct Planned {
    std::vector<PlannedPoint> points;
    std::set<std::int64_t> done;
  };
  /// Adds the points to the store and plans their traces.
  Planned plan(const std::vector<StudyPoint>& points);
  /// Runs what the store has not finished. Throws as the engine does.
  void run(const Planned& planned);

  /// Plans and runs these points, and returns all their outcomes: the same after any interruption. Throws as
  /// the engine does.
  std::vector<PointOutcome> run(const std::vector<StudyPoint>& points);

  /// Returns the counts of all that was run here.
  const EngineSummary& summary() const { return summary_; }

 private:
  PointTask task_;
  Engine& engine_;
  StudyStore& store_;
  EngineSummary summary_;
};

}  // namespace fringetwin::study
