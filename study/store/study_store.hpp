// SPDX-License-Identifier: Apache-2.0
// The results of a study in one SQLite file, one row per run: what is in it survives a kill, a full disk and
// several writers. On a disk of this machine: SQLite's write-ahead log needs shared memory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "study/plan/study_head.hpp"
#include "study/plan/study_point.hpp"
#include "twin/base/not_copyable.hpp"

namespace fringetwin::study {

enum class PointStatus { pending, done, failed };

/// A row of the table: a point, and what became of it.
struct StoredPoint {
  StudyPoint point;
  PointStatus status = PointStatus::pending;
  PointOutcome outcome;     ///< of done and failed
  std::string version;      ///< of the program that ran it
  std::string host;         ///< and where
  std::string finished_at;  ///< UTC, "2026-01-31T12:00:00Z"
};

class StudyStore : NotCopyable {
 public:
  /// Opens the study's file or makes it. Several processes may have it open. Throws UserError(usage) for
  /// another study's, an older or newer or another program's file, and where nothing can be written; a file
  /// that is not ours stays as it is. `version`: of this program. Like everything here it throws
  /// UserError(input) where the file is damaged.
  StudyStore(const std::filesystem::path& file, const StudyIdentity& identity, const std::string& version);
  ~StudyStore();

  /// Returns the study's StudyIdentity::digest().
  std::string digest() const;
  /// Adds those that are not there yet, as pending. Throws UserError(input) where the file has another point
  /// of that id.
  void add(const PointSequence& points);
  /// Returns what has not finished, by id; a failed point has.
  std::vector<StudyPoint> pending() const;
  /// Stores outcomes in one transaction: when it returns the outcomes are on the disk, when it throws none of
  /// them is. A point that has finished keeps its first outcome. Only for points added before.
  void record(const std::vector<PointOutcome>& outcomes);
  /// Returns the rows from one id to another, both included, by id.
  std::vector<StoredPoint> rows(std::int64_t first_id = 0,
                                std::int64_t last_id = std::numeric_limits<std::int64_t>::max()) const;

  /// Returns all rows. Throws UserError(input) unless they are those of the points that were added to this
  /// object, each of them finished.
  std::vector<StoredPoint> finished_rows() const;
  /// Throws UserError(input) where a row's id is not in 0 ... n - 1.
  void refuse_rows_from(std::int64_t n) const;

  struct Counts {
    std::int64_t pending = 0, done = 0, failed = 0;
  };
  Counts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Returns "pending", "done" or "failed".
const char* status_name(PointStatus status);

/// Returns the table as CSV, one line per row: id, the settings by key, noise seed, status, reason, the
/// results by name. Only what the study determines: two runs of one study give the same bytes wherever, in
/// whatever order and after whatever interruption. A result that is not a number is an empty cell.
std::string study_csv(const std::vector<StoredPoint>& rows);

/// Returns the same table as JSON (fringetwin-study-table/1, docs/formats/study.md). A result that is not a
/// number is null.
std::string study_table_json(const std::vector<StoredPoint>& rows);

}  // namespace fringetwin::study
