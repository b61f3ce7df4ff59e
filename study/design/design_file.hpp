// SPDX-License-Identifier: Apache-2.0
// Reads the plan of a STUDY.toml of kind = "design" (docs/FORMATS.md).
#pragma once
#include <string>
#include <vector>

#include "study/design/design_plan.hpp"

namespace fringetwin {
class TomlTable;
}

namespace fringetwin::study {

/// Returns the keys that a study of this kind has besides those of every study.
std::vector<std::string> design_keys();

/// Throws UserError(usage) with file, line and key.
DesignPlan read_design(const TomlTable& root);

}  // namespace fringetwin::study
