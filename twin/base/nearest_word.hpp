// SPDX-License-Identifier: Apache-2.0
// Finds the known word that a misspelt one may stand for.
#pragma once
#include <string>
#include <vector>

namespace fringetwin {

/// Returns the candidate with the smallest edit distance; nullptr when none is near (more than half of its
/// letters differ).
const std::string* nearest(const std::string& word, const std::vector<std::string>& candidates);

/// Returns the hint of an error message, did you mean "left"?, or an empty text when no candidate is near.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace fringetwin
