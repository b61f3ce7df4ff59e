// SPDX-License-Identifier: Apache-2.0
// Reads the text that stands behind an option: a list, a size, files, a camera and what is said of it.
#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::cli {

/// Returns the items of a list with commas between them.
std::vector<std::string> split_list(const std::string& text);
/// Reads "WIDTHxHEIGHT", px.
std::optional<std::array<int, 2>> parse_size(const std::string& text);

/// Returns the files that match, sorted, as a shell would expand the glob; empty when there is none.
std::vector<std::filesystem::path> glob_files(const std::string& pattern);

struct CameraArgument {
  std::size_t camera = 0;  ///< of the twin
  std::string value;
};
/// Reads "CAMERA=VALUE"; the camera may be left out where there is only one. Throws UserError(usage).
CameraArgument parse_camera_argument(const Twin& twin, const std::string& option, const std::string& text);

}  // namespace fringetwin::cli
