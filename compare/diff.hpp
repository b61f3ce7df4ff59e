// SPDX-License-Identifier: Apache-2.0
// Subtracts two results: takes two result.json and returns their numbers side by side as a text table.
#pragma once
#include <filesystem>
#include <string>

namespace fringetwin::compare {

/// Returns B - A of every number that both result.json have, of every table, matched by the names of the rows
/// (object, camera, pattern, direction ...), as a text table; z where both sigmas are known and the runs do
/// not share images (z takes the two errors as independent); what only one run has is listed below. `a`, `b`:
/// a result.json or the folder that holds it. Throws UserError(input) for a missing file, broken JSON or
/// another schema.
std::string diff_results(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace fringetwin::compare
