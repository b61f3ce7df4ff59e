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

}  // namespace fringetwin::cli
