// SPDX-License-Identifier: Apache-2.0
// Writes what shells complete command lines of the program with: commands, options, choices, files, folders.
#pragma once
#include <string>

#include "cli/manual/command_text.hpp"

namespace fringetwin::cli {

std::string bash_completion(const CommandText& program);
std::string zsh_completion(const CommandText& program);
std::string fish_completion(const CommandText& program);

}  // namespace fringetwin::cli
