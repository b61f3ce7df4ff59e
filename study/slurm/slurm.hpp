// SPDX-License-Identifier: Apache-2.0
// Calls Slurm's own commands to submit, look at and cancel jobs. Its accounting database is not needed.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin::study::slurm {

/// A task of a job array, as squeue shows it.
struct Task {
  std::string state, reason;  ///< "RUNNING", "PENDING" and "Resources", "OUT_OF_MEMORY" ...
  bool alive() const;         ///< runs, waits, or is being put back into the queue
};
struct Job {
  std::string id;  ///< empty: Slurm knows none of this name (any more)
  std::map<std::size_t, Task> tasks;
  bool alive() const;
  bool completed() const;  ///< all tasks, without a fault
  std::size_t count(const std::string& state) const;
};

/// Throws UserError(usage) unless there are Slurm's commands and a controller that answers.
void check();

/// Submits a script and returns the job's id. Throws UserError(usage) with what sbatch says.
std::string submit(const std::vector<std::string>& arguments, const std::filesystem::path& script);

/// Returns this user's job of that name; nullopt when the controller does not answer; *why is what squeue
/// says.
std::optional<Job> find_job(const std::string& name, std::string* why);

/// Looks at a job again and again, and keeps what Slurm forgets: it drops ended tasks after a while.
class Watch {
 public:
  /// Begins with a job that has just been submitted.
  void begin(const std::string& name, const std::string& id);
  /// Throws Cancelled. Tells the user when nothing runs, and why, and when Slurm does not answer. That it
  /// knows no task of the job counts the second time in a row: a controller that has just started may say so.
  void ask(const std::string& name);
  /// Asks until no point is left, or Slurm has no task of the job any more. `collect`: takes over what the
  /// tasks have finished, and returns whether points are left. Throws Cancelled, and what `collect` throws.
  void follow(const std::string& name, const std::function<bool()>& collect);
  /// False: the job is as it was when Slurm answered last.
  bool answered() const { return answered_; }
  const Job& job() const { return job_; }
  std::map<std::size_t, std::string> states() const;  ///< "TIMEOUT (TimeLimit)"

 private:
  Job job_;
  std::string name_, waits_for_;
  bool answered_ = true, silent_ = false, empty_ = false;
};

/// Cancels this user's jobs of that name; false when that could not be done.
bool cancel(const std::string& name);

/// Returns whether these arguments, or sbatch's own variables, say how much memory a job gets.
bool declares_memory(const std::vector<std::string>& arguments);

/// Returns the option of sbatch, set by this program, that a word gives: "--job-name" for "-Jx"; "" for none.
std::string own_option(const std::string& word);

}  // namespace fringetwin::study::slurm
