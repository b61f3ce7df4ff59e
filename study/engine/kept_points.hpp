// SPDX-License-Identifier: Apache-2.0
// Points through an engine into the study's store.
#pragma once
#include "study/engine/engine.hpp"
#include "study/store/study_store.hpp"

namespace fringetwin::study {

class KeptPoints {
 public:
  KeptPoints(PointTask task, Engine& engine, StudyStore& store)
      : task_(std::move(task)), engine_(engine), store_(store) {
    task_.study = store.digest();
  }

  /// Runs what the store has not finished, and gives all their outcomes: the same after any interruption.
  /// Throws as the engine does.
  std::vector<PointOutcome> run(const std::vector<StudyPoint>& points);

  /// Of all that was run here.
  const EngineSummary& summary() const { return summary_; }

 private:
  PointTask task_;
  Engine& engine_;
  StudyStore& store_;
  EngineSummary summary_;
};

}  // namespace fringetwin::study
