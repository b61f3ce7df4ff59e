// SPDX-License-Identifier: Apache-2.0
// Adds the options that ask for files beside those that a command always writes.
#pragma once
#include "cosim/extra_files.hpp"

namespace CLI {
class App;
}

namespace fringetwin::cli {

/// Adds --npz; to a command that writes a page also --figures.
void add_npz_flag(CLI::App& sub, cosim::ExtraFiles& extra);
void add_figures_flag(CLI::App& sub, cosim::ExtraFiles& extra);

/// Returns the exit code of a command that has written all it could and would end with `otherwise`. Throws
/// UserError(usage) where drawings are asked for and gnuplot did not make all of DIR/report.html; a command
/// that fails anyway keeps its code, and a warning says it.
int code_with_figures(bool asked_for, const std::filesystem::path& dir, int otherwise);

}  // namespace fringetwin::cli
