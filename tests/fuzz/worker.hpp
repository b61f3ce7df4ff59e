// SPDX-License-Identifier: Apache-2.0
// One process that gives changed inputs to one reader until the reader breaks or the time is over, and its
// supervisor, which keeps the input that broke it.
#pragma once
#include <chrono>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "tests/fuzz/target.hpp"

namespace fringetwin::fuzz {

/// No input may take more than these.
constexpr double kLongestSeconds = 5.0;  ///< of computing, for one input
constexpr double kLongestWait = 60.0;    ///< of doing nothing: a pipe that nobody writes to
constexpr std::size_t kLargestMemory = std::size_t{2} << 30;  ///< bytes

struct WorkerPlan {
  const Target* target = nullptr;
  std::uint64_t seed = 1;
  double seconds = 1.0;                      ///< of computing, the seeds included
  std::optional<std::string> replayed = {};  ///< this input alone
  std::set<std::string> known = {};          ///< inputs that broke it before: not read again
  std::filesystem::path corpus = {};         ///< where inputs that ran new code are kept; empty: nowhere
};

/// How a process ended.
struct WorkerEnd {
  std::size_t runs = 0, kept = 0;
  double seconds = 0.0;
  std::string fault = {};  ///< what broke; empty: nothing
  std::string input = {};  ///< that did it
  std::string log = {};    ///< what the process has written to stderr last
  bool too_long = false;   ///< the input took more than kLongestSeconds of computing
};

/// Runs a process and waits for its end.
WorkerEnd run_worker(const WorkerPlan& plan);

}  // namespace fringetwin::fuzz
