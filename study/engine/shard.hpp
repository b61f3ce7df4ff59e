// SPDX-License-Identifier: Apache-2.0
// The points of one task of a job array: how a study is cut, and the file that a task reads its share from.
#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "study/engine/worker.hpp"

namespace fringetwin::study {

/// At most `count` shards, about equally large, and one more for each point of `alone`. Points of one trace
/// stay together unless they are more than a shard's share. The same points give the same shards.
std::vector<std::vector<PlannedPoint>> cut_shards(const std::vector<PlannedPoint>& points, std::size_t count,
                                                  const std::set<std::int64_t>& alone = {});

struct Shard {
  WorkerTask task;
  std::vector<PlannedPoint> points;
};
/// FOLDER/shard-INDEX.jsonl: the task, then a point a line.
void write_shard(const std::filesystem::path& folder, std::size_t index, const Shard& shard);
/// Throws UserError(input) naming file and line.
Shard read_shard(const std::filesystem::path& folder, std::size_t index);
/// Without reading the points; false where there is no such file.
bool has_one_point(const std::filesystem::path& folder, std::size_t index);

}  // namespace fringetwin::study
