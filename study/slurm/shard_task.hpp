// SPDX-License-Identifier: Apache-2.0
// Runs one task of a job array, on the node where Slurm starts it.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace fringetwin::study {

struct ShardTask {
  std::filesystem::path round;      ///< a SlurmRound's folder
  std::size_t index = 0;            ///< of the shard
  std::vector<std::string> worker;  ///< as of LocalOptions
  std::string version;              ///< of this program
};

/// Runs the points of the shard that no earlier attempt has finished; as many at a time as
/// SLURM_CPUS_PER_TASK says. Throws UserError, which the attempt's file then has as well, and Cancelled.
void run_shard(const ShardTask& task);

}  // namespace fringetwin::study
