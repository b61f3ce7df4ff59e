// SPDX-License-Identifier: Apache-2.0
// What several subcommands share: options, the reading of what stands behind them (lists, sizes, a camera and
// its images), the twin.toml of a rig that was calibrated or imported, and the answer to --device list.
#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosim/simulate.hpp"
#include "twin/twin.hpp"

namespace CLI {
class App;
}

namespace fringetwin::cli {

/// Adds --samples --sampler --phase-error --gray-error --seed --device
void add_render_flags(CLI::App& sub, cosim::RenderRequest& request);

/// Returns the items of a list with commas between them.
std::vector<std::string> split_list(const std::string& text);
/// Reads "WIDTHxHEIGHT", px.
std::optional<std::array<int, 2>> parse_size(const std::string& text);

/// Returns a twin.toml to go on from, of devices by their names, each with whether it is the projector; their
/// models are NAME.cameramodel beside it.
std::string starting_twin_toml(const std::string& name,
                               const std::vector<std::pair<std::string, bool>>& devices);

/// Prints the Vulkan devices, one a line, on stdout; returns the exit code (4 when there is none).
int print_devices();

/// Returns the files that match, sorted, as a shell would expand the glob; empty when there is none.
std::vector<std::filesystem::path> glob_files(const std::string& pattern);

struct CameraArgument {
  std::size_t camera = 0;  ///< of the twin
  std::string value;
};
/// Reads "CAMERA=VALUE"; the camera may be left out where there is only one. Throws UserError(usage).
CameraArgument parse_camera_argument(const Twin& twin, const std::string& option, const std::string& text);

}  // namespace fringetwin::cli
