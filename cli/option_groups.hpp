// SPDX-License-Identifier: Apache-2.0
// Groups the options of a command by what they are for, as its help, its manual page and completions show
// them.
#pragma once
#include <CLI/CLI.hpp>

namespace fringetwin::cli {

/// What options are for that many commands have.
inline constexpr const char* kInput = "Input";
inline constexpr const char* kOutput = "Output";
inline constexpr const char* kComparison = "What is compared";
inline constexpr const char* kRefinement = "Refinement";
inline constexpr const char* kRendering = "Rendering";
inline constexpr const char* kComputing = "Computing";

/// Puts the options that are added to the command from here on into this group.
inline void begin_group(CLI::App& command, const char* purpose) { command.option_defaults()->group(purpose); }

}  // namespace fringetwin::cli
