// SPDX-License-Identifier: Apache-2.0
// Reads what STUDY.toml says of the uncertain inputs, in all kinds of studies that have them
// (docs/formats/study.md).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "study/uncertain/uncertain_inputs.hpp"

namespace fringetwin {
class TomlTable;
}

namespace fringetwin::study {

struct UncertainSettings {
  UncertainInputs inputs;    ///< without the directions of the calibration: VirtualRig counts them
  bool calibration = false;  ///< draw the rig from the covariance that the twin names
};

/// Returns the keys at the top that read_uncertain_settings reads, and after them `keys`.
std::vector<std::string> with_uncertain_keys(const std::vector<std::string>& keys);

/// Middles of distributions are the twin's own values where [[uncertain]] has no `value`. Throws
/// UserError(usage) with file, line and key.
UncertainSettings read_uncertain_settings(const TomlTable& root, const std::filesystem::path& twin);

/// Returns the inputs with the number of directions of the twin's calibration. Throws UserError where it
/// cannot be read.
UncertainInputs complete_inputs(const UncertainSettings& settings, const std::filesystem::path& twin);

/// Returns "coverage", the share of the values that intervals hold; default 0.95.
double read_coverage(const TomlTable& root);

}  // namespace fringetwin::study
