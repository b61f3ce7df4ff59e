// SPDX-License-Identifier: Apache-2.0
#include "study/engine/local_engine.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <thread>

#include "study/engine/worker.hpp"
#include "study/engine/worker_process.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {

/// Workers that have a task, and nothing to do.
class IdleWorkers {
 public:
  /// Returns a worker that has this task, or nothing; workers of another task are let go.
  std::unique_ptr<WorkerProcess> take(const std::string& task) {
    if (task != task_) idle_.clear();
    task_ = task;
    while (!idle_.empty()) {
      std::unique_ptr<WorkerProcess> worker = std::move(idle_.back());
      idle_.pop_back();
      bool ended = false;
      worker->answers(&ended);
      if (!ended) return worker;
    }
    return nullptr;
  }
  void give(std::unique_ptr<WorkerProcess> worker) { idle_.push_back(std::move(worker)); }

 private:
  std::string task_;
  std::vector<std::unique_ptr<WorkerProcess>> idle_;
};

namespace {

constexpr int kPollMs = 200;  // how soon Ctrl-C is noticed at the latest
constexpr int kMostFalseStarts = 3;
constexpr std::size_t kMostWarnings = 50;

// Says which point is next: one of the trace that the worker has, else of a trace that nobody has, else of
// the trace with the most points left.
class Queue {
 public:
  Queue(const std::vector<PlannedPoint>& plan, const std::set<std::int64_t>& done) {
    for (const PlannedPoint& p : plan)
      if (!done.contains(p.point.id)) {
        groups_[p.group].push_back(&p);
        ++size_;
      }
  }
  std::size_t size() const { return size_; }

  const PlannedPoint* next(const std::optional<std::size_t>& at_hand, const std::set<std::size_t>& taken) {
    if (size_ == 0) return nullptr;
    auto from = at_hand ? groups_.find(*at_hand) : groups_.end();
    if (from == groups_.end())
      from = std::ranges::find_if(groups_, [&](const auto& g) { return !taken.contains(g.first); });
    if (from == groups_.end())
      from = std::ranges::max_element(
          groups_, [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    const PlannedPoint* point = from->second.front();
    from->second.pop_front();
    if (from->second.empty()) groups_.erase(from);
    --size_;
    return point;
  }

 private:
  std::map<std::size_t, std::deque<const PlannedPoint*>> groups_;
  std::size_t size_ = 0;
};

struct Worker {
  std::unique_ptr<WorkerProcess> process;
  bool ready = false;
  const PlannedPoint* point = nullptr;  ///< in progress
  std::chrono::steady_clock::time_point since;
  std::optional<std::size_t> group;  ///< whose trace it has
  std::string last_error;
};

class LocalRun {
 public:
  LocalRun(const PointTask& task, const std::vector<PlannedPoint>& plan, const std::set<std::int64_t>& done,
           const LocalOptions& options, const Outlook& outlook, IdleWorkers& idle,
           const std::function<void(const PointOutcome&)>& finished)
      : options_(options),
        outlook_(outlook),
        task_(task_line(task, options.device)),
        idle_(idle),
        finished_(finished),
        queue_(plan, done) {}

  EngineSummary run() {
    if (queue_.size() == 0) return {};
    const int cores = options_.cores > 0
                          ? options_.cores
                          : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const int jobs = static_cast<int>(std::min<std::size_t>(
        static_cast<std::size_t>(options_.jobs > 0 ? options_.jobs : cores), queue_.size()));
    // Points side by side use the cores better than the threads of one point do.
    const int threads = std::max(1, cores / jobs);
    environment_ = {fmt::format("OMP_NUM_THREADS={}", threads), fmt::format("LP_NUM_THREADS={}", threads)};
    Progress progress("study", std::max(outlook_.in_all, outlook_.finished + queue_.size()), true,
                      outlook_.finished);
    progress_ = &progress;
    workers_.resize(static_cast<std::size_t>(jobs));
    for (Worker& w : workers_) start(w);
    while (std::ranges::any_of(workers_, [](const Worker& w) { return w.process != nullptr; })) attend();
    return summary_;
  }

 private:
  void start(Worker& w) {
    w = {};
    if (queue_.size() == 0) return;
    w.process = idle_.take(fmt::format("{}\n{}", task_, fmt::join(environment_, "\n")));
    if (w.process) {
      w.ready = true;
      hand_out(w);
      return;
    }
    w.process = std::make_unique<WorkerProcess>(options_.worker, environment_);
    w.process->send(task_);
  }

  void attend() {
    throw_if_cancelled();
    std::vector<pollfd> fds;
    for (const Worker& w : workers_)
      if (w.process)
        for (const int fd : {w.process->answers_fd(), w.process->errors_fd()}) fds.push_back({fd, POLLIN, 0});
    poll(fds.data(), fds.size(), kPollMs);
    throw_if_cancelled();
    for (Worker& w : workers_)
      if (w.process) listen(w);
  }

  void listen(Worker& w) {
    hear_warnings(w);
    bool ended = false;
    for (const std::string& line : w.process->answers(&ended)) {
      answer(w, parse_answer(line));
      if (!ended) hand_out(w);
    }
    if (ended) bury(w);
  }

  void hear_warnings(Worker& w) {
    for (const std::string& line : w.process->errors()) {
      if (line.empty()) continue;
      w.last_error = line;
      constexpr std::string_view kPrefix = "fringetwin: warning: ";
      // Every point may give the same warning: the user is told once.
      if (line.starts_with(kPrefix) && warnings_.size() < kMostWarnings && warnings_.insert(line).second)
        options_.warned ? options_.warned(line.substr(kPrefix.size())) : warn(line.substr(kPrefix.size()));
    }
  }

  void answer(Worker& w, const WorkerAnswer& a) {
    switch (a.kind) {
      case WorkerAnswer::Kind::unfit:
        throw UserError(static_cast<ExitCode>(a.exit_code), "", a.text);
      case WorkerAnswer::Kind::ready:
        w.ready = true;
        false_starts_ = 0;
        break;
      case WorkerAnswer::Kind::outcome:
        w.group = w.point->group;
        w.point = nullptr;
        finish(a.outcome);
        break;
    }
  }

  void hand_out(Worker& w) {
    std::set<std::size_t> taken;
    for (const Worker& other : workers_) {
      if (other.point) taken.insert(other.point->group);
      if (other.group) taken.insert(*other.group);
    }
    w.point = queue_.next(w.group, taken);
    if (!w.point) {
      idle_.give(std::move(w.process));
      w = {};
      return;
    }
    w.since = std::chrono::steady_clock::now();
    if (options_.begun) options_.begun(w.point->point.id);
    // If the worker has died, sending fails unseen: listen() finds that its answers have ended.
    w.process->send(point_line(*w.point));
  }

  // The process has ended: its point, if it had one, has failed, and another process takes its place.
  void bury(Worker& w) {
    const std::string end = w.process->end();
    hear_warnings(w);
    const std::string said = w.last_error.empty() ? "" : "; it said: " + w.last_error;
    if (!w.ready && ++false_starts_ >= kMostFalseStarts)
      throw UserError(ExitCode::device, "study", "no worker starts: it " + end + said,
                      "what is finished is safe: run the command again");
    if (w.point) {
      PointOutcome lost{
          .id = w.point->point.id,
          .failed = true,
          .reason = "its process " + end + said,
          .seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - w.since).count(),
          .traced = w.group != w.point->group};
      finish(lost);
    }
    start(w);
  }

  void finish(const PointOutcome& outcome) {
    finished_(outcome);
    summary_.count(outcome);
    progress_->advance();
  }

  const LocalOptions& options_;
  const Outlook outlook_;
  std::string task_;
  IdleWorkers& idle_;
  const std::function<void(const PointOutcome&)>& finished_;
  Queue queue_;
  std::vector<std::string> environment_;
  std::vector<Worker> workers_;
  std::set<std::string> warnings_;
  Progress* progress_ = nullptr;
  int false_starts_ = 0;
  EngineSummary summary_;
};

}  // namespace

LocalEngine::LocalEngine(LocalOptions options)
    : options_(std::move(options)), idle_(std::make_unique<IdleWorkers>()) {}
LocalEngine::~LocalEngine() = default;

EngineSummary LocalEngine::run(const PointTask& task, const std::vector<PlannedPoint>& plan,
                               const std::set<std::int64_t>& done,
                               const std::function<void(const PointOutcome&)>& finished) {
  return LocalRun(task, plan, done, options_, outlook_, *idle_, finished).run();
}

}  // namespace fringetwin::study
