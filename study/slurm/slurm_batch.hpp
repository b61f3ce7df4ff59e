// SPDX-License-Identifier: Apache-2.0
// Keeps a study's Slurm job arrays on disk, where their tasks and the process that submits them exchange
// points and outcomes (docs/formats/study.md). Each array has a folder, called a round; a later round has the
// points that the earlier ones left unfinished.
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "study/slurm/attempt_log.hpp"
#include "study/slurm/shard.hpp"

namespace fringetwin::study {

/// Holds what is known of one round: its job array and how that ended.
struct SlurmRound {
  std::filesystem::path folder;
  std::string job_name;  ///< unique: it holds random digits
  std::string version;   ///< the version that the program must have in the tasks
  /// True once nobody waits for the job array any more; a task that starts later stops at once.
  bool ended = false;
  bool cancelled = false;  ///< a user cancelled it, so that no point is to blame
  /// Slurm's state of each task at its end: "TIMEOUT (TimeLimit)".
  std::map<std::size_t, std::string> states{};

  /// Reads round.json and, where there is one, ended.json of a round's folder. Throws UserError(input) where
  /// they cannot be read.
  static SlurmRound read(const std::filesystem::path& folder);
  /// Marks the round as ended, in memory and by ended.json; does nothing when it has ended before.
  void end(bool was_cancelled, std::map<std::size_t, std::string> last_states);
  /// Returns the last line that is not empty in the log of a task.
  std::string last_words(std::size_t task) const;
  /// Returns how the tasks that did not complete ended, for a message: "2 tasks TIMEOUT (TimeLimit); the log
  /// of task 3 ends: ...".
  std::string fate() const;
};

/// Holds all rounds of one study.
class SlurmBatch {
 public:
  /// Reads the rounds that are in the folder; writes nothing.
  explicit SlurmBatch(std::filesystem::path folder);

  /// Returns the latest round; nullptr when there is none yet.
  SlurmRound* last() { return rounds_.empty() ? nullptr : &rounds_.back()->round; }
  /// Writes the folder of a new round with one shard of points for each task; the script of the job array is
  /// not in it yet. The folder gets its name only when it is complete. Returns false when another process has
  /// begun a round first: last() is then that one.
  bool begin_round(const WorkerTask& task, const std::vector<std::vector<PlannedPoint>>& shards,
                   const std::string& version);
  /// Removes the latest round with its folder: for a job array that Slurm did not accept.
  void drop_round();

  /// Returns what the tasks of all rounds have written since the last call; `unfit`, the reason why a task
  /// could run no point at all, is that of the latest round only.
  AttemptNews read();

  /// Counts how often a task ended badly while it ran one point.
  struct Death {
    int times = 0;
    bool alone = false;  ///< the last time, the task had no other point that could be to blame
    std::string last{};  ///< how the last one ended: "its task ended TIMEOUT (TimeLimit); its log ends: ..."
  };
  using Deaths = std::map<std::int64_t, Death>;
  /// Returns, by their ids, the points that were running when their task failed for good in a way that a
  /// point can cause: a crash, too little memory or a time limit, but no lost node.
  Deaths deaths() const;

 private:
  struct Entry {
    SlurmRound round;
    AttemptReader attempts;
  };
  /// Reads the rounds that have appeared in the folder since.
  void take_up_new_rounds();
  std::filesystem::path folder_;
  std::vector<std::unique_ptr<Entry>> rounds_;
};

/// Returns the ids of at most `most` of these points: those with the most deaths.
std::set<std::int64_t> most_often_dead(const SlurmBatch::Deaths& deaths,
                                       const std::vector<PlannedPoint>& points, std::size_t most);

}  // namespace fringetwin::study
