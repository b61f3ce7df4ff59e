// SPDX-License-Identifier: Apache-2.0
// Images that an option names: CAMERA=GLOB.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::cli {

/// Files that match, sorted, as a shell would expand the glob; empty when there is none.
std::vector<std::filesystem::path> glob_files(const std::string& pattern);

struct CameraArgument {
  std::size_t camera = 0;  ///< of the twin
  std::string value;
};
/// "CAMERA=VALUE"; the camera may be left out where there is only one. Throws UserError(usage).
CameraArgument parse_camera_argument(const Twin& twin, const std::string& option, const std::string& text);

}  // namespace fringetwin::cli
