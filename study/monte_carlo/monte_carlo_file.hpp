// SPDX-License-Identifier: Apache-2.0
// Reads the plan of a STUDY.toml of kind = "monte-carlo" (docs/FORMATS.md): what is uncertain, and when there
// are enough trials.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/uncertain/uncertain_file.hpp"

namespace fringetwin {
class TomlTable;
}

namespace fringetwin::study {

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> monte_carlo_keys();

/// Middles of distributions are the twin's own values where [[uncertain]] has no `value`. Throws
/// UserError(usage) with file, line and key.
MonteCarloPlan read_monte_carlo(const TomlTable& root, const std::filesystem::path& twin);

}  // namespace fringetwin::study
