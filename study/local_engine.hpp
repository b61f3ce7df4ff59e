// SPDX-License-Identifier: Apache-2.0
// Runs the points of a study in worker processes of this machine.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "study/engine.hpp"

namespace fringetwin::study {

struct LocalOptions {
  std::vector<std::string> worker;  ///< command of a process that calls run_worker(); its path first
  int jobs = 0;                     ///< workers; 0: one per core
  std::string device;               ///< a part of a Vulkan device's name
};

class IdleWorkers;

/// Points that share a trace meet in one worker while there is other work for the others. A worker's crash is
/// the failure of its point. Workers stay for a next run() of the same task. Throws UserError when no worker
/// can work (no device); after Ctrl-C the points in progress are dropped.
class LocalEngine final : public Engine {
 public:
  explicit LocalEngine(LocalOptions options);
  ~LocalEngine() override;
  EngineSummary run(const PointTask& task, const std::vector<PlannedPoint>& plan,
                    const std::set<std::int64_t>& done,
                    const std::function<void(const PointOutcome&)>& finished) override;

 private:
  LocalOptions options_;
  std::unique_ptr<IdleWorkers> idle_;
};

}  // namespace fringetwin::study
