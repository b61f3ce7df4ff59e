// SPDX-License-Identifier: Apache-2.0
// Runs the points of a study in worker processes of this machine.
#pragma once
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "study/point_runner.hpp"

namespace fringetwin::study {

struct LocalOptions {
  std::vector<std::string> worker;  ///< command of a process that calls run_worker(); its path first
  int jobs = 0;                     ///< workers; 0: one per core
  std::string device;               ///< a part of a Vulkan device's name
};

struct LocalSummary {
  std::size_t finished = 0, failed = 0;  ///< failed ones are among the finished
  std::size_t traced = 0;                ///< points whose light was traced; the others took it over
};

/// Runs every point of the plan whose id is not in `done`. Points that share a trace meet in one worker while
/// there is other work for the others. `finished` is called from this thread, in the order in which points
/// end; what it throws ends the study. A worker's crash is the failure of its point. Throws UserError when no
/// worker can work (no device), Cancelled after Ctrl-C: the points in progress are dropped then.
LocalSummary run_local(const PointTask& task, const std::vector<PlannedPoint>& plan,
                       const std::set<std::int64_t>& done, const LocalOptions& options,
                       const std::function<void(const PointOutcome&)>& finished);

}  // namespace fringetwin::study
