// SPDX-License-Identifier: Apache-2.0
// Runs a program with text on its standard input.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace fringetwin::report {

struct ProcessResult {
  int status = 0;  ///< exit status; 128 + signal when killed
  std::string out, err;
};

/// argv[0] is looked up in PATH; no shell. Input, output and errors are moved at the same time, so
/// nothing blocks on a full pipe. nullopt when the program cannot be started.
std::optional<ProcessResult> run_process(const std::vector<std::string>& argv, const std::string& input);

}  // namespace fringetwin::report
