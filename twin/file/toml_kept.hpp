// SPDX-License-Identifier: Apache-2.0
// Takes out of a twin.toml what stays true of a rig whose lenses and poses have been calibrated anew: what it
// projects, its sensors and its light.
#pragma once
#include <filesystem>
#include <map>
#include <string>

namespace fringetwin {

/// Holds lines of TOML to be written into another twin.toml, with a line feed behind each.
struct KeptTables {
  std::string fringes;                           ///< the keys of [fringes]; empty where there is none
  std::string projector;                         ///< intensity of [projector]; empty where it is not stated
  std::map<std::string, std::string> of_camera;  ///< `sensor = {...}`, by the camera's name
};

/// Returns what a twin.toml that load_twin() has accepted says of them. Files are named by their absolute
/// paths. Throws UserError(usage) where the file has gone or changed since then.
KeptTables kept_tables(const std::filesystem::path& twin_file);

}  // namespace fringetwin
