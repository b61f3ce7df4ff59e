// SPDX-License-Identifier: Apache-2.0
// Cuts the points of a study into shards, one for each task of a job array, and writes and reads the file of
// a shard.
#pragma once
#include <filesystem>
#include <set>
#include <vector>

#include "study/engine/worker.hpp"

namespace fringetwin::study {

/// Returns at most `count` shards, about equally large, and one more for each point of `alone`. Points of one
/// trace stay together unless they are more than a shard's share. The same points give the same shards.
std::vector<std::vector<PlannedPoint>> cut_shards(const std::vector<PlannedPoint>& points, std::size_t count,
                                                  const std::set<std::int64_t>& alone = {});

struct Shard {
  WorkerTask task;
  std::vector<PlannedPoint> points;
};
/// Writes FOLDER/shard-INDEX.jsonl: the task, then a point a line.
void write_shard(const std::filesystem::path& folder, std::size_t index, const Shard& shard);
/// Reads such a file. Throws UserError(input) naming file and line.
Shard read_shard(const std::filesystem::path& folder, std::size_t index);
/// Returns whether a shard has one point, without parsing it; false where there is no such file.
bool has_one_point(const std::filesystem::path& folder, std::size_t index);

}  // namespace fringetwin::study
