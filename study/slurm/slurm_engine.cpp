// SPDX-License-Identifier: Apache-2.0
#include "study/slurm/slurm_engine.hpp"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <thread>

#include "study/slurm/slurm.hpp"
#include "study/slurm/slurm_batch.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/sha256.hpp"

namespace fringetwin::study {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kMostDeaths = 3;  // of a task with the same point in progress
constexpr int kMostFruitlessRounds = 3;
constexpr std::size_t kMostSlurmWarnings = 50;
constexpr auto kPatienceWithCancelled = 10s;

/// Returns a name that depends on what is run, not on how much of it is done: the same study comes back to
/// its folder.
std::string batch_name(const PointTask& task, const std::vector<PlannedPoint>& plan) {
  FT_CHECK(!task.study.empty(), "an engine that keeps results must know the study");
  Sha256 digest;
  const auto add = [&](std::string line) {
    line += '\n';
    digest.add(std::as_bytes(std::span(line)));
  };
  add(task.study);
  add(task_line(task, ""));
  for (const PlannedPoint& p : plan) add(point_line(p));
  return digest.hex().substr(0, 16);
}

class SlurmRun {
 public:
  SlurmRun(const PointTask& task, const std::vector<PlannedPoint>& plan, const std::set<std::int64_t>& done,
           const SlurmOptions& options, const Outlook& outlook,
           const std::function<void(const PointOutcome&)>& finished)
      : task_{task, options.device},
        options_(options),
        outlook_(outlook),
        finished_(finished),
        batch_(options.folder / batch_name(task, plan)) {
    for (const PlannedPoint& p : plan)
      if (!done.contains(p.point.id)) left_.emplace(p.point.id, &p);
  }

  EngineSummary run() {
    if (left_.empty()) return {};
    Progress progress("study", std::max(outlook_.in_all, outlook_.finished + left_.size()), true,
                      outlook_.finished);
    progress_ = &progress;
    collect();
    while (!left_.empty()) {
      try {
        const std::size_t before = left_.size();
        const bool attached = take_up();
        if (!attached && !submit()) continue;  // another process was faster: to its round
        watching_ = true;
        watch_.follow(batch_.last()->job_name, [&] { return collect(); });
        watching_ = false;
        if (!left_.empty()) end_round(before);
      } catch (const Cancelled&) {
        give_up(true);
        throw;
      } catch (...) {
        give_up(false);
        throw;
      }
    }
    if (SlurmRound* round = batch_.last()) round->end(false, watch_.states());
    return summary_;
  }

 private:
  /// Looks for an array of an earlier run; true when it is still with Slurm.
  bool take_up() {
    SlurmRound* round = batch_.last();
    if (round == nullptr) return false;
    submitted_ = !round->ended;  // until Slurm says otherwise: a Ctrl-C may come before it answers
    for (watch_.ask(round->job_name); !watch_.answered(); watch_.ask(round->job_name))
      for (const auto until = Clock::now() + 2s; Clock::now() < until; std::this_thread::sleep_for(50ms))
        throw_if_cancelled();
    if (!watch_.job().alive()) {
      round->end(watch_.job().count("CANCELLED") > 0, watch_.states());
      submitted_ = false;
      return false;
    }
    submitted_ = true;
    say(fmt::format("Slurm job {} is at work on these points: it is watched", watch_.job().id));
    return true;
  }

  /// Begins a round with what is left; false when another process has begun one first.
  bool submit() {
    std::vector<PlannedPoint> points;
    for (const auto& [id, p] : left_) points.push_back(*p);
    const auto shards = shards_of(points, batch_.deaths(), options_.shards);
    throw_if_cancelled();
    if (!batch_.begin_round(task_, shards, options_.version)) return false;
    SlurmRound& round = *batch_.last();
    submitted_ = true;
    try {
      watch_.begin(round.job_name, submit_round(round, shards.size(), options_));
    } catch (const UserError&) {
      throw_if_cancelled();  // sbatch may have submitted before
      batch_.drop_round();
      submitted_ = false;
      throw;
    }
    say(fmt::format("Slurm job {}: {} point{} in {} task{}", watch_.job().id, points.size(),
                    points.size() == 1 ? "" : "s", shards.size(), shards.size() == 1 ? "" : "s"));
    return true;
  }

  /// Decides on what the tasks have left.
  void end_round(std::size_t left_before) {
    SlurmRound& round = *batch_.last();
    const bool was_ended = round.ended;  // cancelled by an earlier run, or ended by another process
    const bool cancelled = watch_.job().count("CANCELLED") > 0 && !was_ended;
    round.end(cancelled, watch_.states());
    submitted_ = false;
    if (cancelled) {
      say(fmt::format("Slurm job {} was cancelled (scancel)", watch_.job().id));
      throw Cancelled();
    }
    for (const auto& [id, death] : batch_.deaths())
      if (death.times >= kMostDeaths && death.alone && left_.contains(id)) {
        PointOutcome lost{
            .id = id, .failed = true, .reason = fmt::format("{} times {}", death.times, death.last)};
        finish(lost);
      }
    fruitless_ = left_.size() < left_before ? 0 : fruitless_ + (was_ended ? 0 : 1);
    const std::string fate = round.fate();
    if (fruitless_ >= kMostFruitlessRounds)
      throw UserError(ExitCode::device, fmt::format("Slurm job {}", watch_.job().id),
                      fmt::format("{} times no task has finished a point: {}", fruitless_, fate),
                      "the program, the twin and the output folder must lie on a disk that the nodes share "
                      "under the same path; the logs are in " +
                          round.folder.string());
    if (!left_.empty() && !was_ended)
      warn(fmt::format("Slurm job {} left {} of its points undone ({}): they are submitted again",
                       watch_.job().id, left_.size(), fate));
  }

  /// Takes over what the tasks have finished; true while points are left.
  bool collect() {
    const AttemptNews news = batch_.read();
    for (const PointOutcome& outcome : news.outcomes)
      if (left_.contains(outcome.id)) finish(outcome);
    for (const std::string& text : news.warnings) {
      if (warnings_.size() == kMostSlurmWarnings || !warnings_.insert(text).second) continue;
      warn(text);
      if (warnings_.size() == kMostSlurmWarnings)
        warn("what else the tasks' files are warned of is not shown");
    }
    if (news.unfit && watching_)
      throw UserError(static_cast<ExitCode>(news.unfit->exit_code), "node " + news.unfit->host,
                      news.unfit->sentence);
    return !left_.empty();
  }

  void finish(const PointOutcome& outcome) {
    finished_(outcome);
    left_.erase(outcome.id);
    summary_.count(outcome);
    progress_->tick();
  }

  /// Cancels the array: nothing runs on for a command that has ended; what its tasks finish until then is
  /// kept. Only where this process is told to go (the end of a session) the array stays: it is found again.
  void give_up(bool keep_the_rest) {
    SlurmRound* round = batch_.last();
    watching_ = false;
    if (!submitted_ || round == nullptr) return;
    const std::string& id = watch_.job().id;  // empty: Slurm has not told it yet
    const std::string& job = id.empty() ? round->job_name : id;
    if (cancel_signal() == SIGHUP || cancel_signal() == SIGTERM) {
      say(fmt::format("Slurm job {} goes on; the same command watches it again", job));
      return;
    }
    const bool cancelled = slurm::cancel(round->job_name);
    if (!cancelled)
      warn(fmt::format("Slurm job {} could not be cancelled: end it by scancel {}", job,
                       id.empty() ? "--name=" + job : id));
    try {
      round->end(true, watch_.states());
      for (const auto until = Clock::now() + kPatienceWithCancelled; Clock::now() < until;) {
        std::string why;
        const auto now = slurm::find_job(round->job_name, &why);
        if (!now || !now->alive()) break;
        std::this_thread::sleep_for(200ms);
      }
      if (keep_the_rest) collect();
    } catch (const UserError& e) {  // the first fault is the one to be told
      warn(e.what());
    }
    if (cancelled) say(fmt::format("Slurm job {} is cancelled", job));
  }

  const WorkerTask task_;
  const SlurmOptions& options_;
  const Outlook outlook_;
  const std::function<void(const PointOutcome&)>& finished_;
  SlurmBatch batch_;
  std::map<std::int64_t, const PlannedPoint*> left_;
  slurm::Watch watch_;  ///< of the last round's job
  bool watching_ = false;
  bool submitted_ = false;  ///< an array may be with Slurm
  int fruitless_ = 0;       ///< rounds in a row
  std::set<std::string> warnings_;
  Progress* progress_ = nullptr;
  EngineSummary summary_;
};

}  // namespace

SlurmEngine::SlurmEngine(SlurmOptions options) : options_(std::move(options)) { slurm::check(); }

EngineSummary SlurmEngine::run(const PointTask& task, const std::vector<PlannedPoint>& plan,
                               const std::set<std::int64_t>& done,
                               const std::function<void(const PointOutcome&)>& finished) {
  return SlurmRun(task, plan, done, options_, outlook_, finished).run();
}

}  // namespace fringetwin::study
