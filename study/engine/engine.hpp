// SPDX-License-Identifier: Apache-2.0
// The interface of what runs the points of a study: processes of this machine, or a cluster.
#pragma once
#include <cstdint>
#include <functional>
#include <set>
#include <vector>

#include "study/run/point_runner.hpp"

namespace fringetwin::study {

struct EngineSummary {
  std::size_t finished = 0, failed = 0;  ///< failed ones are among the finished
  std::size_t traced = 0;                ///< points whose light was traced; the others took it over

  void count(const PointOutcome& outcome) {
    ++finished;
    failed += outcome.failed ? 1 : 0;
    traced += outcome.traced ? 1 : 0;
  }
  void add(const EngineSummary& other) {
    finished += other.finished;
    failed += other.failed;
    traced += other.traced;
  }
};

/// How far a study is when an engine begins with some of its points: for what is said of the progress alone.
struct Outlook {
  std::size_t finished = 0;  ///< points before these
  std::size_t in_all = 0;    ///< as far as that is known; 0: these and no others
};

class Engine {
 public:
  virtual ~Engine() = default;
  /// Takes the outlook of the next run().
  void expect(const Outlook& outlook) { outlook_ = outlook; }
  /// Runs every point of the plan whose id is not in `done`. `finished` is called from this thread, once for
  /// each, in the order in which they end; what it throws ends the study. A point's own fault is an outcome.
  /// Throws UserError when no point can be run at all, Cancelled after Ctrl-C.
  virtual EngineSummary run(const PointTask& task, const std::vector<PlannedPoint>& plan,
                            const std::set<std::int64_t>& done,
                            const std::function<void(const PointOutcome&)>& finished) = 0;

 protected:
  Outlook outlook_;
};

}  // namespace fringetwin::study
