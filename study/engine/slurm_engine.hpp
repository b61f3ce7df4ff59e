// SPDX-License-Identifier: Apache-2.0
// Runs the points of a study as job arrays of a Slurm cluster.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "study/engine/engine.hpp"

namespace fringetwin::study {

struct SlurmOptions {
  std::filesystem::path folder;        ///< on a disk that the nodes share under the same path
  std::filesystem::path program;       ///< ours, likewise: a task is PROGRAM study-shard ROUND INDEX
  std::string version;                 ///< of it
  std::string device;                  ///< a part of a Vulkan device's name
  int jobs = 1;                        ///< points at a time in a task, a core each
  int shards = 0;                      ///< tasks of an array; 0: by the number of points
  std::vector<std::string> arguments;  ///< further ones of sbatch
};

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
