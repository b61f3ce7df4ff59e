// SPDX-License-Identifier: Apache-2.0
// What distinguishes one kind of study from another, as an interface: run_study() walks every study through
// these functions. To add a kind: its plan, reader and Kind in a folder of their own, and a line in
// study_file.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "study/kind/kept_points.hpp"
#include "study/page/report_parts.hpp"
#include "study/plan/study_head.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {

class Kind {
 public:
  virtual ~Kind() = default;

  /// Completes the plan from the twin's files and returns points that between them name every key and file of
  /// the study (check_study); called first. Throws UserError.
  virtual PointSequence plan() = 0;
  /// Returns what all points of the completed plan have in common.
  virtual PointTask task() const = 0;

  /// Says what is planned, runs the points that the store lacks, and works out the result. Throws as the
  /// engine does.
  virtual void run(KeptPoints& points) = 0;
  /// Returns the number of points in all; nothing where it follows from the results.
  virtual std::optional<std::size_t> points_in_all() const { return std::nullopt; }
  /// Throws UserError(usage) where the study as it is now cannot go on with the points that the store has:
  /// before anything of an earlier run is taken away.
  virtual void check(const StudyStore& /*store*/) const {}

  /// Whether there is a result.json beside the table of the points.
  virtual bool has_result() const { return true; }
  /// Returns the text of result.json.
  virtual std::string write() const { return {}; }
  /// Returns the page. Throws Cancelled.
  virtual StudyReport report(const StudyRecord& study) const = 0;

  /// Returns what is said of the results on stdout, in whole lines.
  virtual std::string tell(const StudyRecord& study, const EngineSummary& summary) const = 0;
  /// Returns what can be said on stdout of a study that was stopped, from its rows so far, in whole lines.
  virtual std::string tell_stopped(const std::vector<StoredPoint>& /*rows*/) const { return {}; }
  /// Whether a study of this kind has a page before it is finished.
  virtual bool has_page_so_far() const { return false; }
  /// Returns the page of a study that is not finished, from its rows so far; nothing where the kind has none.
  /// Throws Cancelled.
  virtual std::optional<StudyReport> report_so_far(const StudyRecord& /*study*/) const {
    return std::nullopt;
  }
  /// Returns the exit code, after a warning unless it is `ok`; called last.
  virtual ExitCode verdict() const { return ExitCode::ok; }
};

/// Returns "1 point", "12 points".
inline std::string points_text(std::size_t n) { return std::to_string(n) + (n == 1 ? " point" : " points"); }

}  // namespace fringetwin::study
