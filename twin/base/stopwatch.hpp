// SPDX-License-Identifier: Apache-2.0
// Measures how long a piece of work takes: wall and CPU time since a start, and wall time by named stages.
#pragma once
#include <chrono>
#include <map>
#include <string>

namespace fringetwin {

/// Wall time, and CPU time of all threads of this process (a software Vulkan device's included).
struct Elapsed {
  double wall_s = 0.0, cpu_s = 0.0;
};

/// Runs from its construction on.
class Stopwatch {
 public:
  Stopwatch();
  Elapsed elapsed() const;

 private:
  double wall_start_s_, cpu_start_s_;
};

/// Adds up the wall time of named stages, of which one runs at a time. Each is told when it begins and ends,
/// where that is asked for (say_more).
class StageTimer {
 public:
  /// Ends the stage that runs, if any, and starts this one.
  void start(const std::string& stage);
  void stop();
  std::map<std::string, double> seconds;  ///< by stage, those that have ended

 private:
  std::string stage_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace fringetwin
