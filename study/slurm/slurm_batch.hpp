// SPDX-License-Identifier: Apache-2.0
// What the tasks of a study's job arrays share with the process that submits them (docs/formats/study.md): a
// folder per array, called a round. A later round has the points that the earlier ones left.
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

struct SlurmRound {
  std::filesystem::path folder;
  std::string job_name;  ///< that nobody else has
  std::string version;   ///< of the program that its tasks must be
  /// Nothing of it counts on Slurm any more: a task that starts late stops at once.
  bool ended = false;
  bool cancelled = false;                       ///< and its points are not to blame for it
  std::map<std::size_t, std::string> states{};  ///< of its tasks at their end, "TIMEOUT (TimeLimit)"

  /// Throws UserError(input) where it cannot be read.
  static SlurmRound read(const std::filesystem::path& folder);
  void end(bool was_cancelled, std::map<std::size_t, std::string> last_states);
  /// The last line in the log of a task.
  std::string last_words(std::size_t task) const;
  /// "2 tasks TIMEOUT (TimeLimit); the log of task 3 ends: ..."
  std::string fate() const;
};

class SlurmBatch {
 public:
  /// Takes up the rounds that are there; makes nothing.
  explicit SlurmBatch(std::filesystem::path folder);

  /// nullptr: none yet.
  SlurmRound* last() { return rounds_.empty() ? nullptr : &rounds_.back()->round; }
  /// All files of a round but its script; it is there as a whole or not at all. Another process may have been
  /// first: then last() is that one's, and false is returned.
  bool begin_round(const WorkerTask& task, const std::vector<std::vector<PlannedPoint>>& shards,
                   const std::string& version);
  /// As if it had not been begun.
  void drop_round();

  /// News of all rounds; `unfit` of the last one only.
  AttemptNews read();

  struct Death {
    int times = 0;
    bool alone = false;  ///< the last time: no other point of the task can be to blame
    std::string last{};  ///< "its task ended TIMEOUT (TimeLimit); its log ends: ..."
  };
  using Deaths = std::map<std::int64_t, Death>;
  /// Points in progress when their task ended for good in a way that a point can cause, however often.
  Deaths deaths() const;

 private:
  struct Entry {
    SlurmRound round;
    AttemptReader attempts;
  };
  void take_up();
  std::filesystem::path folder_;
  std::vector<std::unique_ptr<Entry>> rounds_;
};

/// At most `most` of the points that died, most often dead first.
std::set<std::int64_t> most_often_dead(const SlurmBatch::Deaths& deaths,
                                       const std::vector<PlannedPoint>& points, std::size_t most);

}  // namespace fringetwin::study
