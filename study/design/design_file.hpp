// SPDX-License-Identifier: Apache-2.0
// Reads the plan of a STUDY.toml of kind = "design" (docs/formats/study.md), and makes the Kind that runs it.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "study/design/design_plan.hpp"
#include "study/kind/kind.hpp"

namespace fringetwin {
class TomlTable;
}

namespace fringetwin::study {

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> design_keys();

/// Throws UserError(usage) with file, line and key.
DesignPlan read_design(const TomlTable& root);

/// The head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const DesignPlan& plan);

}  // namespace fringetwin::study
