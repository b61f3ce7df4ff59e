// SPDX-License-Identifier: Apache-2.0
// Reads the plan of a STUDY.toml of kind = "volume-map" (docs/formats/study.md), and makes the Kind that runs
// it.
#pragma once
#include <memory>

#include "study/kind/kind.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> volume_map_keys();

/// Throws UserError(usage) with file, line and key.
VolumeMapPlan read_volume_map(const TomlTable& root, const std::filesystem::path& twin);

/// The head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const VolumeMapPlan& plan);

}  // namespace fringetwin::study
