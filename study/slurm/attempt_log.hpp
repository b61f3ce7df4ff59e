// SPDX-License-Identifier: Apache-2.0
// Writes and reads what one attempt at a task leaves: a file of its own to which it only appends lines of
// JSON, so that it needs no lock on a network share, survives a kill, and shows which points were run where.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "study/plan/study_point.hpp"
#include "twin/base/not_copyable.hpp"

namespace fringetwin::study {

/// Who has written the lines of a file.
struct AttemptHead {
  std::string job, host, version;  ///< job: as Slurm calls the task, "12_3"
  int restart = 0;                 ///< how often Slurm has put it back into the queue
};

/// Each line is on the disk when a function returns. Throws UserError(input) where it cannot be written.
class AttemptLog : NotCopyable {
 public:
  /// FOLDER/shard-SHARD.attempt-N.jsonl, N the first that nobody has.
  AttemptLog(const std::filesystem::path& folder, std::size_t shard, const AttemptHead& head);
  ~AttemptLog();

  void begun(std::int64_t id);
  void finished(const PointOutcome& outcome);
  void warning(const std::string& text);
  /// Notes that no point can be run here, and why.
  void unfit(const std::string& sentence, int exit_code);

 private:
  void append(const std::string& line);
  std::filesystem::path file_;
  int fd_ = -1;
};

/// What attempts have written since they were read last.
struct AttemptNews {
  struct Unfit {
    std::string host, sentence;
    int exit_code = 0;
  };
  std::vector<PointOutcome> outcomes;  ///< with host and version; one point may come twice
  std::vector<std::string>
      warnings;  ///< of the points, of lines that are none, and of files that cannot be read
  std::optional<Unfit> unfit;
};

/// The attempts in a folder. A torn last line is left until the rest of it comes; a line that is none is
/// warned of with file and line, its point is then not finished. A file that cannot be read is warned of
/// likewise, and looked at again.
class AttemptReader {
 public:
  explicit AttemptReader(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Returns what is new.
  AttemptNews read();
  /// Returns the points that a shard's last attempt began without coming to an end, and the shard.
  std::map<std::int64_t, std::size_t> broken_off() const;

 private:
  struct File {
    std::uintmax_t offset = 0;
    std::size_t lines = 0;
    AttemptHead head;
    std::set<std::int64_t> in_progress;
  };
  void read(const std::filesystem::path& path, File* file, AttemptNews* news);
  std::filesystem::path folder_;
  std::map<std::pair<std::size_t, std::size_t>, File> files_;  ///< by shard and number
};

}  // namespace fringetwin::study
