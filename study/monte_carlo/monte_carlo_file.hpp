// SPDX-License-Identifier: Apache-2.0
// Reads the plan of a STUDY.toml of kind = "monte-carlo" (docs/formats/study.md): what is uncertain, and when
// there are enough trials; and makes the Kind that runs it.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "study/kind/kind.hpp"
#include "study/monte_carlo/monte_carlo_study.hpp"

namespace fringetwin {
class TomlTable;
}

namespace fringetwin::study {

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> monte_carlo_keys();

/// Middles of distributions are the twin's own values where [[uncertain]] has no `value`. Throws
/// UserError(usage) with file, line and key.
MonteCarloPlan read_monte_carlo(const TomlTable& root, const std::filesystem::path& twin);

/// The head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const MonteCarloPlan& plan);

}  // namespace fringetwin::study
