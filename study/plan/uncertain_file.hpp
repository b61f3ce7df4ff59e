// SPDX-License-Identifier: Apache-2.0
// What STUDY.toml says of the uncertain inputs, in all kinds that have them (docs/FORMATS.md).
#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "study/plan/uncertain_inputs.hpp"

namespace fringetwin {
class TomlTable;
}

namespace fringetwin::study {

struct UncertainSettings {
  UncertainInputs inputs;    ///< without the directions of the calibration: VirtualRig counts them
  bool calibration = false;  ///< draw the rig from the covariance that the twin names
};

/// "key" or "keys" of a [[vary]], [[uncertain]] or [[choose]]; none may be among those taken.
std::vector<std::string> read_study_keys(const TomlTable& table, std::set<std::string>* taken);

/// The keys at the top that read_uncertain_settings reads.
const std::vector<std::string>& uncertain_keys();

/// Middles of distributions are the twin's own values where [[uncertain]] has no `value`. Throws
/// UserError(usage) with file, line and key.
UncertainSettings read_uncertain_settings(const TomlTable& root, const std::filesystem::path& twin);

/// The inputs with the directions of the twin's calibration. Throws UserError where it cannot be read.
UncertainInputs complete_inputs(const UncertainSettings& settings, const std::filesystem::path& twin);

/// "coverage" of intervals, default 0.95.
double read_coverage(const TomlTable& root);

/// Whether the twin's file has a sphere of this name.
bool is_sphere(const TomlTable& twin, const std::string& object);

}  // namespace fringetwin::study
