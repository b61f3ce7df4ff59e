// SPDX-License-Identifier: Apache-2.0
// Reads the plan of a STUDY.toml of kind = "optimise" (docs/FORMATS.md).
#pragma once
#include "study/optimise/optimise.hpp"
#include "study/uncertain/uncertain_file.hpp"

namespace fringetwin::study {

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> optimise_keys();

/// Throws UserError(usage) with file, line and key.
OptimisePlan read_optimise(const TomlTable& root, const std::filesystem::path& twin);

}  // namespace fringetwin::study
