// SPDX-License-Identifier: Apache-2.0
// Submits the points of a study to Slurm: how they are cut into the tasks of a job array, and the script and
// arguments that sbatch gets.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "study/slurm/slurm_batch.hpp"

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

/// Returns the points of each task. Points that died before get a task of their own: alone they take no other
/// along. `wanted`: tasks of an array; 0: by the number of points.
std::vector<std::vector<PlannedPoint>> shards_of(const std::vector<PlannedPoint>& points,
                                                 const SlurmBatch::Deaths& deaths, int wanted);

/// Writes the script of a round with so many shards, submits it, and returns the job's id. Throws UserError.
std::string submit_round(const SlurmRound& round, std::size_t shards, const SlurmOptions& options);

}  // namespace fringetwin::study
