// SPDX-License-Identifier: Apache-2.0
// Reads the plan of a STUDY.toml of kind = "optimise" (docs/formats/study.md), and makes the Kind that runs
// it.
#pragma once
#include <memory>

#include "study/kind/kind.hpp"
#include "study/optimise/optimise.hpp"

namespace fringetwin::study {

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> optimise_keys();

/// Throws UserError(usage) with file, line and key.
OptimisePlan read_optimise(const TomlTable& root, const std::filesystem::path& twin);

/// The head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const OptimisePlan& plan);

}  // namespace fringetwin::study
