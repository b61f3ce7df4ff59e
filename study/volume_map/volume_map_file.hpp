// SPDX-License-Identifier: Apache-2.0
// Reads the plan of a STUDY.toml of kind = "volume-map" (docs/FORMATS.md).
#pragma once
#include "study/uncertain/uncertain_file.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> volume_map_keys();

/// Throws UserError(usage) with file, line and key.
VolumeMapPlan read_volume_map(const TomlTable& root, const std::filesystem::path& twin);

}  // namespace fringetwin::study
