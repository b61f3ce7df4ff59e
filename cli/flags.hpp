// SPDX-License-Identifier: Apache-2.0
// Options that several subcommands share.
#pragma once

namespace CLI {
class App;
}

namespace fringetwin::cli {

struct RenderFlags;

/// --samples --sampler --phase-error --seed --device
void add_render_flags(CLI::App& sub, RenderFlags& flags);

/// The Vulkan devices, one a line on stdout; returns the exit code (4 when there is none).
int print_devices();

}  // namespace fringetwin::cli
