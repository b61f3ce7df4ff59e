// SPDX-License-Identifier: Apache-2.0
// Runs the points of a study as job arrays of a Slurm cluster.
#pragma once
#include "study/engine/engine.hpp"
#include "study/slurm/slurm_submit.hpp"

namespace fringetwin::study {

/// Submits, watches and takes over what the tasks finish while they run. Ctrl-C cancels the array; any other
/// end of this process leaves it, and the next run goes on with it. What tasks leave undone when they end is
/// submitted again; a point in progress whenever its task ended, three times, has failed.
class SlurmEngine final : public Engine {
 public:
  /// Throws UserError(usage) where Slurm is not there or does not answer.
  explicit SlurmEngine(SlurmOptions options);
  EngineSummary run(const PointTask& task, const std::vector<PlannedPoint>& plan,
                    const std::set<std::int64_t>& done,
                    const std::function<void(const PointOutcome&)>& finished) override;

 private:
  SlurmOptions options_;
};

}  // namespace fringetwin::study
