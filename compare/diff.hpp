// SPDX-License-Identifier: Apache-2.0
// Paired differences of two results.
#pragma once
#include <filesystem>
#include <string>

namespace fringetwin::compare {

/// B - A of every number that both result.json name (fits, gain, gray, phase, matched by object,
/// camera, pattern, direction), as a text table; z where both sigmas are known and the runs do not share
/// images (z takes the two errors as independent); what only one run has is listed below. `a`, `b`: a
/// result.json or the folder that holds it. Throws UserError(input) for a missing file, broken JSON or
/// another schema.
std::string diff_results(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace fringetwin::compare
