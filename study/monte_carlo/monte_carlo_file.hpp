// SPDX-License-Identifier: Apache-2.0
// STUDY.toml of kind = "monte-carlo" (docs/FORMATS.md): what is uncertain, and when there are enough trials.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/plan/uncertain_file.hpp"

namespace fringetwin {
class TomlTable;
}

namespace fringetwin::study {

struct MonteCarloSettings {
  MonteCarloPlan plan;       ///< without the directions of the calibration: VirtualRig counts them
  bool calibration = false;  ///< draw the rig from the covariance that the twin names
};

/// The keys that a study of this kind has beside those of every study and uncertain_keys().
const std::vector<std::string>& monte_carlo_keys();

/// Middles of distributions are the twin's own values where [[uncertain]] has no `value`. Throws
/// UserError(usage) with file, line and key.
MonteCarloSettings read_monte_carlo(const TomlTable& root, const std::filesystem::path& twin);

}  // namespace fringetwin::study
