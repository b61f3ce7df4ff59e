// SPDX-License-Identifier: Apache-2.0
// Runs a program with text on its standard input.
#pragma once
#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin::report {

struct ProcessResult {
  int status = 0;  ///< exit status; 128 + signal when killed
  std::string out, err;
  std::string killed_for;  ///< empty, or why we ended it: "did not end"
};

/// No page has a plot that takes gnuplot a second, and Slurm's commands give up after 10 to 100 s themselves.
constexpr std::chrono::milliseconds kLongestProcess{120'000};

/// argv[0] is looked up in PATH; no shell. Input, output and errors are moved at the same time, so
/// nothing blocks on a full pipe. nullopt, with errno, when the program cannot be started. It is killed when
/// it has not ended after `longest` or writes more than 256 MiB. A Ctrl-C that comes meanwhile kills it, too,
/// and throws Cancelled. What it has started itself is killed with it. What is
/// run after a Ctrl-C, to tidy up, has 5 s at most.
std::optional<ProcessResult> run_process(const std::vector<std::string>& argv, const std::string& input,
                                         std::chrono::milliseconds longest = kLongestProcess);

}  // namespace fringetwin::report
