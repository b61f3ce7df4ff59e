// SPDX-License-Identifier: Apache-2.0
// STUDY.toml of kind = "optimise" (docs/FORMATS.md).
#pragma once
#include "study/optimise/optimise.hpp"
#include "study/plan/uncertain_file.hpp"

namespace fringetwin::study {

struct OptimiseSettings {
  OptimisePlan plan;         ///< without the directions of the calibration: VirtualRig counts them
  bool calibration = false;  ///< draw the rig from the covariance that the twin names
};

/// The keys that a study of this kind has beside those of every study and uncertain_keys().
const std::vector<std::string>& optimise_keys();

/// Throws UserError(usage) with file, line and key.
OptimiseSettings read_optimise(const TomlTable& root, const std::filesystem::path& twin);

}  // namespace fringetwin::study
