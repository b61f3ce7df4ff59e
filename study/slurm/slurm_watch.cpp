// SPDX-License-Identifier: Apache-2.0
#include "study/slurm/slurm_watch.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kPatienceWithDisk = 10s, kPatienceWithSlurm = 30s;

/// Waits in proportion to what has passed: short studies are attended to at once, long ones ask rarely.
class Pace {
 public:
  Pace(Clock::duration shortest, Clock::duration longest) : shortest_(shortest), longest_(longest) {}
  bool due() {
    const auto now = Clock::now();
    if (now < next_) return false;
    next_ = now + std::clamp((now - start_) / 10, shortest_, longest_);
    return true;
  }

 private:
  Clock::duration shortest_, longest_;
  Clock::time_point start_ = Clock::now(), next_ = start_;
};

}  // namespace

void watch_round(slurm::Watch* watch, const std::string& job_name, const std::function<bool()>& collect) {
  const auto begin = Clock::now();
  Pace files(200ms, 2s), queue(500ms, 10s);
  bool left = true;
  while (left) {
    throw_if_cancelled();
    if (files.due()) left = collect();
    if (queue.due()) {
      watch->ask(job_name);
      const bool shown = !watch->job().tasks.empty() || Clock::now() - begin > kPatienceWithSlurm;
      if (watch->answered() && shown && !watch->job().alive()) break;
    }
    std::this_thread::sleep_for(50ms);
  }
  left = collect();  // what came between the last look at the files and the end of the tasks
  const auto until = Clock::now() + kPatienceWithDisk;  // a share may show the last lines late
  while (left && watch->job().completed() && Clock::now() < until) {
    throw_if_cancelled();
    std::this_thread::sleep_for(200ms);
    left = collect();
  }
}

}  // namespace fringetwin::study
