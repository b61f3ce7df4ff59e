// SPDX-License-Identifier: Apache-2.0
// Recordings that die between two changes of their folder.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/program/cli_runner.hpp"

namespace fringetwin::testing {

/// Runs the program, which dies before the n-th step that changes `folder` (faults.cpp).
RunResult die_at(int n, const std::filesystem::path& folder, const std::vector<std::string>& args);

/// Kills recordings with all that a set can have before every `every`-th change of their folder, checks that
/// what is left is whole or says that it is not, and resumes them. Returns how many were killed.
int kill_between_changes(int every);

}  // namespace fringetwin::testing
