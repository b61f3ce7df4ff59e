// SPDX-License-Identifier: Apache-2.0
#include "study/slurm/slurm_submit.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "report/text.hpp"
#include "study/slurm/slurm.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::study {
namespace {

constexpr std::size_t kPointsPerShard = 16, kMostShards = 64;
constexpr int kMegabytesPerCore = 1200;  // a worker's peak is about 850 on the paper's sphere
constexpr int kMinutesPerTask = 60;
constexpr std::size_t kMostAlone = 64;  // points with a task of their own: clusters limit an array's size

// What a user may want otherwise is declared here: the environment (SBATCH_...) and --slurm-args go first.
std::string script(const SlurmRound& round, const SlurmOptions& options) {
  // Per core: a task has a worker for each core that it gets. sbatch takes memory in one way only.
  const bool has_memory = slurm::declares_memory(options.arguments);
  std::vector<std::string> command{options.program.string()};
  if (const double limits = file_limits_factor(); limits != 1.0)
    command.insert(command.end(), {"--limits", fmt::format("{}", limits)});
  command.insert(command.end(), {"study-shard", round.folder.string()});
  return fmt::format(
      "#!/bin/sh\n"
      "#SBATCH --nodes=1 --ntasks=1 --cpus-per-task={} --time={}\n"
      "{}exec {} \"$SLURM_ARRAY_TASK_ID\"\n",
      options.jobs, kMinutesPerTask,
      has_memory ? "" : fmt::format("#SBATCH --mem-per-cpu={}M\n", kMegabytesPerCore),
      report::shell_command(command));
}

std::vector<std::string> sbatch_arguments(const SlurmRound& round, std::size_t shards,
                                          const SlurmOptions& options) {
  std::string log;  // Slurm reads % in a file's name, also in that of its folder
  for (const char c : round.folder.string()) log += c == '%' ? std::string("%%") : std::string(1, c);
  std::vector<std::string> all{fmt::format("--array=0-{}", shards - 1),
                               "--requeue",
                               "--open-mode=append",
                               "--job-name=" + round.job_name,
                               "--chdir=" + round.folder.string(),
                               "--output=" + log + "/task-%a.log"};
  all.insert(all.end(), options.arguments.begin(), options.arguments.end());
  return all;
}

}  // namespace

std::vector<std::vector<PlannedPoint>> shards_of(const std::vector<PlannedPoint>& points,
                                                 const SlurmBatch::Deaths& deaths, int wanted) {
  const std::set<std::int64_t> suspects = most_often_dead(deaths, points, kMostAlone);
  std::size_t tasks = wanted > 0
                          ? static_cast<std::size_t>(wanted)
                          : std::min((points.size() + kPointsPerShard - 1) / kPointsPerShard, kMostShards);
  // no more tasks than a user has asked for, unless that is few
  if (tasks > kMostShards) tasks = std::max(tasks - suspects.size(), kMostShards);
  return cut_shards(points, tasks, suspects);
}

std::string submit_round(const SlurmRound& round, std::size_t shards, const SlurmOptions& options) {
  const std::filesystem::path file = round.folder / "task.sh";
  write_text_file(file, script(round, options));
  return slurm::submit(sbatch_arguments(round, shards, options), file);
}

}  // namespace fringetwin::study
