// SPDX-License-Identifier: Apache-2.0
// Foreign file names in the order a person means, and lists of numbers such as "0-11,14,12".
#pragma once
#include <string>
#include <vector>

namespace fringetwin {

/// Runs of digits compare as numbers: img2 before img10. A strict order: names that differ are never equal.
bool natural_less(const std::string& a, const std::string& b);

/// "0-11,14,12": numbers and ranges, also descending. Empty when the text is none, or names more than 100000.
std::vector<int> parse_number_list(const std::string& text);

}  // namespace fringetwin
