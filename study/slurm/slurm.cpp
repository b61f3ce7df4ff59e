// SPDX-License-Identifier: Apache-2.0
#include "study/slurm/slurm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <set>
#include <sstream>
#include <thread>

#include "report/process.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::study::slurm {
namespace {

constexpr const char* kWhere = "--engine slurm";

/// Returns the last thing a command complained of, without its own name.
std::string complaint(const std::string& err) {
  std::istringstream lines(err);
  std::string last;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) last = line;
  for (const char* prefix : {"error: ", "fatal: "})
    if (const auto at = last.find(prefix); at != std::string::npos) return last.substr(at + 7);
  return last.empty() ? "nothing" : last;
}

/// Runs one of Slurm's commands. Throws UserError(usage) where there is none.
report::ProcessResult ask_slurm(const std::vector<std::string>& command) {
  std::optional<report::ProcessResult> said = report::run_process(command, "");
  const int error = said ? 0 : errno;
  // 127: posix_spawn where the missing program is only noticed in the child
  if (error == ENOENT || (said && said->status == 127))
    throw UserError(ExitCode::usage, kWhere, fmt::format("there is no {} in PATH", command.front()),
                    "run it where Slurm's commands are (a login node), or use --engine local");
  if (!said)
    throw UserError(ExitCode::usage, kWhere,
                    fmt::format("{} cannot be started ({})", command.front(), std::strerror(error)));
  if (!said->killed_for.empty()) said->err = fmt::format("it {}", said->killed_for);
  return std::move(*said);
}

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kPatienceWithDisk = 10s, kPatienceWithSlurm = 30s;

/// Waits in proportion to what has passed: short studies are attended to at once, long ones ask rarely.
class Pace {
 public:
  Pace(Clock::duration shortest, Clock::duration longest) : shortest_(shortest), longest_(longest) {}
  bool due() {
    const auto now = Clock::now();
    if (now < next_) return false;
    next_ = now + std::clamp((now - start_) / 10, shortest_, longest_);
    return true;
  }

 private:
  Clock::duration shortest_, longest_;
  Clock::time_point start_ = Clock::now(), next_ = start_;
};

}  // namespace

bool Task::alive() const {
  static const std::set<std::string> ended{
      "BOOT_FAIL", "CANCELLED", "COMPLETED",     "DEADLINE", "FAILED", "NODE_FAIL",
      "PREEMPTED", "REVOKED",   "OUT_OF_MEMORY", "TIMEOUT",  "GONE"};  // ours: Slurm knows it no more
  return !ended.contains(state);
}

bool Job::alive() const {
  return std::ranges::any_of(tasks, [](const auto& t) { return t.second.alive(); });
}

bool Job::completed() const { return count("COMPLETED") == tasks.size(); }

std::size_t Job::count(const std::string& state) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(tasks, [&](const auto& t) { return t.second.state == state; }));
}

void check() {
  for (const char* command : {"sbatch", "scancel"}) ask_slurm({command, "--version"});
  std::string why;
  if (!find_job("fringetwin", &why))
    throw UserError(ExitCode::usage, kWhere, fmt::format("Slurm does not answer, squeue says: {}", why),
                    "run the command again when it does, or use --engine local");
}

std::string submit(const std::vector<std::string>& arguments, const std::filesystem::path& script) {
  std::vector<std::string> command{"sbatch", "--parsable"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  command.push_back(script.string());
  const report::ProcessResult result = ask_slurm(command);
  if (result.status != 0)
    throw UserError(ExitCode::usage, kWhere, fmt::format("sbatch refuses: {}", complaint(result.err)),
                    "see --slurm-args, --shards and --jobs");
  const std::string id = result.out.substr(0, result.out.find_first_of(";\n"));  // "12;cluster"
  if (!parse_number<std::uint64_t>(id))
    throw UserError(ExitCode::usage, kWhere,
                    fmt::format("sbatch does not tell the number of its job: \"{}\"", id.substr(0, 100)),
                    "see which sbatch is the first in PATH");
  return id;
}

std::optional<Job> find_job(const std::string& name, std::string* why) {
  const report::ProcessResult result = ask_slurm(
      {"squeue", "--me", "--name=" + name, "--noheader", "--array", "--states=all", "--format=%F|%K|%T|%r"});
  if (result.status != 0) {
    *why = complaint(result.err);
    return std::nullopt;
  }
  Job job;
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::string id, index, state, reason;
    std::getline(cells, id, '|');
    std::getline(cells, index, '|');
    std::getline(cells, state, '|');
    std::getline(cells, reason);
    const std::optional<std::size_t> task = parse_number<std::size_t>(index);
    if (!task) continue;
    job.id = id;
    job.tasks[*task] = {state, reason};
  }
  return job;
}

void Watch::begin(const std::string& name, const std::string& id) {
  job_ = {id, {}};
  name_ = name;
  waits_for_.clear();
  empty_ = false;
}

void Watch::ask(const std::string& name) {
  if (name != name_) begin(name, "");
  std::string why;
  std::optional<Job> now = find_job(name, &why);
  throw_if_cancelled();
  if (!silent_ && !now) warn(fmt::format("Slurm does not answer ({}): waiting for it", why));
  silent_ = !now;
  answered_ = now && (!now->tasks.empty() || empty_);
  empty_ = now && now->tasks.empty();
  if (!answered_) return;
  for (const auto& [index, task] : job_.tasks)
    now->tasks.try_emplace(index, task.alive() ? Task{"GONE", "its end was not seen"} : task);
  if (now->id.empty()) now->id = job_.id;
  job_ = std::move(*now);
  const auto waiting = std::ranges::find_if(
      job_.tasks, [](const auto& t) { return t.second.state == "PENDING" && t.second.reason != "None"; });
  const std::string reason = waiting == job_.tasks.end() ? "" : waiting->second.reason;
  if (!reason.empty() && reason != waits_for_ && job_.count("RUNNING") == 0)
    say(fmt::format("Slurm job {} waits: {}", job_.id, reason));
  waits_for_ = reason;
}

void Watch::follow(const std::string& name, const std::function<bool()>& collect) {
  const auto begin = Clock::now();
  Pace files(200ms, 2s), queue(500ms, 10s);
  bool left = true;
  while (left) {
    throw_if_cancelled();
    if (files.due()) left = collect();
    if (queue.due()) {
      ask(name);
      const bool shown = !job_.tasks.empty() || Clock::now() - begin > kPatienceWithSlurm;
      if (answered_ && shown && !job_.alive()) break;
    }
    std::this_thread::sleep_for(50ms);
  }
  left = collect();  // what came between the last look at the files and the end of the tasks
  const auto until = Clock::now() + kPatienceWithDisk;  // a share may show the last lines late
  while (left && job_.completed() && Clock::now() < until) {
    throw_if_cancelled();
    std::this_thread::sleep_for(200ms);
    left = collect();
  }
}

std::map<std::size_t, std::string> Watch::states() const {
  std::map<std::size_t, std::string> all;
  for (const auto& [index, task] : job_.tasks) all[index] = fmt::format("{} ({})", task.state, task.reason);
  return all;
}

bool cancel(const std::string& name) {
  try {
    return ask_slurm({"scancel", "--me", "--name=" + name}).status == 0;
  } catch (const UserError&) {
    return false;
  }
}

bool declares_memory(const std::vector<std::string>& arguments) {
  for (const char* variable : {"SBATCH_MEM_PER_CPU", "SBATCH_MEM_PER_GPU", "SBATCH_MEM_PER_NODE"})
    if (std::getenv(variable) != nullptr) return true;
  return std::ranges::any_of(arguments, [](const std::string& a) {
    return a == "--mem" || a.starts_with("--mem=") || a.starts_with("--mem-p");
  });
}

std::string own_option(const std::string& word) {
  // --error: the reason of a task's end is read from its one log
  static const std::vector<std::pair<std::string, std::string>> own{
      {"--array", "-a"}, {"--job-name", "-J"}, {"--chdir", "-D"},    {"--output", "-o"},
      {"--error", "-e"}, {"--open-mode", ""},  {"--no-requeue", ""}, {"--wrap", ""}};
  const std::string name = word.substr(0, word.find('='));
  for (const auto& [long_form, short_form] : own) {
    // sbatch takes the beginning of a long option for the whole, and "-Jx" for "-J x"
    if (name.size() > 3 && name.starts_with("--") && long_form.starts_with(name)) return long_form;
    if (!short_form.empty() && word.starts_with(short_form)) return short_form;
  }
  return "";
}

}  // namespace fringetwin::study::slurm
