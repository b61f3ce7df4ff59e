// SPDX-License-Identifier: Apache-2.0
#include "study/slurm/shard_task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "study/engine/local_engine.hpp"
#include "study/slurm/slurm_batch.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/time_and_host.hpp"

namespace fringetwin::study {
namespace {

AttemptHead head_of(const std::string& version) {
  const std::string node = environment_value("SLURMD_NODENAME");
  return {
      fmt::format("{}_{}", environment_value("SLURM_ARRAY_JOB_ID"), environment_value("SLURM_ARRAY_TASK_ID")),
      node.empty() ? host_name() : node, version,
      std::atoi(environment_value("SLURM_RESTART_COUNT").c_str())};
}

}  // namespace

void run_shard(const ShardTask& o) {
  set_quiet(true);
  const SlurmRound round = SlurmRound::read(o.round);
  if (round.ended) return;  // its points are another round's by now
  const std::string name = environment_value("SLURM_JOB_NAME");
  if (!name.empty() && name != round.job_name)
    throw UserError(ExitCode::usage, o.round.string(), fmt::format("belongs to another job than {}", name),
                    "it was made anew since this one was submitted");
  const Shard shard = read_shard(o.round, o.index);
  std::set<std::int64_t> finished;
  for (const PointOutcome& p : AttemptReader(o.round).read().outcomes) finished.insert(p.id);

  AttemptLog log(o.round, o.index, head_of(o.version));
  LocalOptions local{o.worker, std::max(1, std::atoi(environment_value("SLURM_CPUS_PER_TASK").c_str())),
                     shard.task.device};
  local.cores = local.jobs;  // of the node's, those that are ours
  local.begun = [&](std::int64_t id) { log.begun(id); };
  local.warned = [&](const std::string& text) { log.warning(text); };
  try {
    if (round.version != o.version)
      throw UserError(
          ExitCode::usage, "",
          fmt::format("the program has changed since: it was {}, it is {}", round.version, o.version),
          "run the study again");
    LocalEngine(local).run(shard.task.task, shard.points, finished,
                           [&](const PointOutcome& p) { log.finished(p); });
  } catch (const UserError& e) {
    log.unfit(e.what(), static_cast<int>(e.code()));
    throw;
  }
}

}  // namespace fringetwin::study
