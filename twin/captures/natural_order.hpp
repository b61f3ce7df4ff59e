// SPDX-License-Identifier: Apache-2.0
// Sorts foreign file names in the order a person means, and reads lists of numbers such as "0-11,14,12".
#pragma once
#include <string>
#include <vector>

namespace fringetwin {

/// Returns whether a comes before b, with runs of digits compared as numbers: img2 before img10. A strict
/// order: names that differ are never equal.
bool natural_less(const std::string& a, const std::string& b);

/// Returns the numbers of a text such as "0-11,14,12": numbers and ranges, also descending. Empty when the
/// text is no such list, or names more than 100000.
std::vector<int> parse_number_list(const std::string& text);

}  // namespace fringetwin
