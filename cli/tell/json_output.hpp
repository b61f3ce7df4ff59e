// SPDX-License-Identifier: Apache-2.0
// --json: what a command writes as a JSON file goes to stdout, too, for scripts.
#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace fringetwin::cli {

/// Adds the option to a command that writes `name` into its folder.
void add_json_flag(CLI::App& command, bool& json, const std::string& name);

/// Prints a file of this run on stdout where it is asked for; returns whether it is.
bool print_json_if(bool json, const std::filesystem::path& file);

}  // namespace fringetwin::cli
