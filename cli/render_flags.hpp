// SPDX-License-Identifier: Apache-2.0
// Adds the options that every command that renders has, and answers --device list.
#pragma once
#include "cosim/simulate.hpp"

namespace CLI {
class App;
}

namespace fringetwin::cli {

/// Adds --samples --sampler --phase-error --gray-error --seed --device
void add_render_flags(CLI::App& sub, cosim::RenderRequest& request);

/// Prints the Vulkan devices, one a line, on stdout; returns the exit code (4 when there is none).
int print_devices();

}  // namespace fringetwin::cli
