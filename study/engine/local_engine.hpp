// SPDX-License-Identifier: Apache-2.0
// Runs the points of a study in worker processes of this machine.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "study/engine/engine.hpp"

namespace fringetwin::study {

struct LocalOptions {
  std::vector<std::string> worker;  ///< command of a process that calls run_worker(); its path first
  int jobs = 0;                     ///< workers; 0: one per core
  std::string device;               ///< a part of a Vulkan device's name
  int cores = 0;                    ///< that the workers share; 0: the machine's
  std::function<void(std::int64_t)> begun{};         ///< a point is handed out; may be empty
  std::function<void(const std::string&)> warned{};  ///< takes each warning once; empty: warn()
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
