// SPDX-License-Identifier: Apache-2.0
#include "study/slurm/shard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "twin/base/safe_file.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {

using Points = std::vector<PlannedPoint>;

const FileUse kShardUse{.kind = FileKind::table,
                        .what = "share of a task",
                        .hint = "it must lie on a disk that the nodes share under the same path"};

fs::path shard_file(const fs::path& folder, std::size_t index) {
  return folder / fmt::format("shard-{}.jsonl", index);
}

/// Adds the points of a group in pieces of at most `most`, equally large.
void split(const Points& group, std::size_t most, std::vector<Points>* pieces) {
  const std::size_t n = (group.size() + most - 1) / most;
  for (std::size_t i = 0; i < n; ++i)
    pieces->emplace_back(group.begin() + static_cast<std::ptrdiff_t>(group.size() * i / n),
                         group.begin() + static_cast<std::ptrdiff_t>(group.size() * (i + 1) / n));
}

}  // namespace

std::vector<Points> cut_shards(const Points& points, std::size_t count, const std::set<std::int64_t>& alone) {
  std::map<std::size_t, Points> groups;
  std::vector<Points> single;
  std::size_t n = 0;
  for (const PlannedPoint& p : points) {
    if (alone.contains(p.point.id)) {
      single.push_back({p});
    } else {
      groups[p.group].push_back(p);
      ++n;
    }
  }
  std::vector<Points> pieces, shards(std::min(std::max<std::size_t>(count, 1), n));
  if (n > 0)
    for (const auto& [group, members] : groups)
      split(members, (n + shards.size() - 1) / shards.size(), &pieces);
  // the largest first, each into the emptiest
  std::ranges::stable_sort(pieces, [](const Points& a, const Points& b) { return a.size() > b.size(); });
  for (Points& piece : pieces) {
    Points& shard = *std::ranges::min_element(
        shards, [](const Points& a, const Points& b) { return a.size() < b.size(); });
    shard.insert(shard.end(), piece.begin(), piece.end());
  }
  std::erase_if(shards, [](const Points& shard) { return shard.empty(); });
  shards.insert(shards.end(), single.begin(), single.end());
  return shards;
}

void write_shard(const fs::path& folder, std::size_t index, const Shard& shard) {
  std::string text = task_line(shard.task.task, shard.task.device) + '\n';
  for (const PlannedPoint& p : shard.points) text += point_line(p) + '\n';
  write_text_file(shard_file(folder, index), text);
}

bool has_one_point(const fs::path& folder, std::size_t index) {
  try {
    const std::string text = read_whole_text(shard_file(folder, index), kShardUse);
    return std::ranges::count(text, '\n') == 2;
  } catch (const UserError&) {
    return false;
  }
}

Shard read_shard(const fs::path& folder, std::size_t index) {
  const fs::path file = shard_file(folder, index);
  std::istringstream in(read_whole_text(file, kShardUse));
  std::size_t n = 0;
  try {
    Shard shard;
    for (std::string line; std::getline(in, line);) {
      ++n;
      if (n == 1)
        shard.task = parse_task(line);
      else
        shard.points.push_back(parse_point(line));
    }
    if (n > 0) return shard;
  } catch (const nlohmann::json::exception&) {
  } catch (const std::out_of_range&) {
  }
  throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), n), "is damaged",
                  "end the job with scancel and run the study again");
}

}  // namespace fringetwin::study
