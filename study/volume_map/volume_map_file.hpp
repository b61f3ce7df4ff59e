// SPDX-License-Identifier: Apache-2.0
// STUDY.toml of kind = "volume-map" (docs/FORMATS.md).
#pragma once
#include "study/plan/uncertain_file.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {

struct VolumeMapSettings {
  VolumeMapPlan plan;        ///< without the directions of the calibration: VirtualRig counts them
  bool calibration = false;  ///< draw the rig from the covariance that the twin names
};

/// The keys that a study of this kind has beside those of every study and uncertain_keys().
const std::vector<std::string>& volume_map_keys();

/// Throws UserError(usage) with file, line and key.
VolumeMapSettings read_volume_map(const TomlTable& root, const std::filesystem::path& twin);

}  // namespace fringetwin::study
