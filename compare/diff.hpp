// SPDX-License-Identifier: Apache-2.0
// Subtracts two results: takes two result.json and returns their numbers side by side as a text table.
#pragma once
#include <filesystem>
#include <string>

namespace fringetwin::compare {

/// Returns a text table of the differences B - A of all numbers that both result.json have; rows are matched
/// by their names (object, camera, pattern, direction ...), and what only one run has is listed below. Where
/// both standard errors are known, z = (B - A) / sqrt(sigma_A^2 + sigma_B^2) is printed too, unless the runs
/// share images: their errors are then not independent. `a` and `b` name a result.json or the folder that
/// holds it. Throws UserError(input) for a missing file, broken JSON or another schema.
std::string diff_results(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace fringetwin::compare
