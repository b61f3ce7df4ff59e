// SPDX-License-Identifier: Apache-2.0
#include "twin/base/stopwatch.hpp"

#include <fmt/format.h>

#include <ctime>

#include "twin/base/progress.hpp"

namespace fringetwin {
namespace {

double wall_now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double cpu_now_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

Stopwatch::Stopwatch() : wall_start_s_(wall_now_s()), cpu_start_s_(cpu_now_s()) {}

Elapsed Stopwatch::elapsed() const { return {wall_now_s() - wall_start_s_, cpu_now_s() - cpu_start_s_}; }

void StageTimer::start(const std::string& stage) {
  stop();
  stage_ = stage;
  say_more("stage " + stage);
  begin_ = std::chrono::steady_clock::now();
}

void StageTimer::stop() {
  if (stage_.empty()) return;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin_;
  seconds[stage_] += took.count();
  say_more(fmt::format("stage {} took {:.3f} s", stage_, took.count()));
  stage_.clear();
}

}  // namespace fringetwin
