// SPDX-License-Identifier: Apache-2.0
// Runs the points of a study that have not been run yet: points go in, an engine simulates and measures those
// whose outcomes the study's store lacks, and the outcomes are stored as they come.
#pragma once
#include <cstdint>
#include <functional>
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

  /// Holds points with the traces of rays that they share, and the ids of those that are finished.
  struct Planned {
    std::vector<PlannedPoint> points;
    std::set<std::int64_t> done;
  };
  /// Adds the points to the store and plans their traces.
  Planned plan(const PointSequence& points);
  /// Runs the points that are not in `done`. Throws as the engine does.
  void run(const Planned& planned);

  /// Plans the points, runs those that the store has not finished, and returns the outcomes of all of them,
  /// which are the same after any interruption. `outlook`: how far the study is. `announce` is called with
  /// the points that will run, where there are any. Throws as the engine does.
  std::vector<PointOutcome> run(const PointSequence& points, const Outlook& outlook = {},
                                const std::function<void(const std::vector<StudyPoint>&)>& announce = {});

  /// Says of how many points there were gate warnings after the first one, whose were told when it came.
  void tell_later_gate_warnings() const;
  /// Returns the counts of all that was run here.
  const EngineSummary& summary() const { return summary_; }

 private:
  void tell_first_gate_warnings(const PointOutcome& outcome);

  PointTask task_;
  Engine& engine_;
  StudyStore& store_;
  EngineSummary summary_;
  std::size_t with_gate_warnings_ = 0;  ///< points
};

}  // namespace fringetwin::study
