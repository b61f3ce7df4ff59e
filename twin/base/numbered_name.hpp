// SPDX-License-Identifier: Apache-2.0
// File names with a number, such as "left/%04d.png".
#pragma once
#include <optional>
#include <string>

namespace fringetwin {

struct NumberedName {
  std::string before, after;
  int digits = 0;  ///< at least so many, with leading zeros
  std::string operator()(int number) const;
  /// The number that gives this name.
  std::optional<int> number_of(const std::string& name) const;
};

/// nullopt unless the text has one number, %d or %04d, and no other %.
std::optional<NumberedName> parse_numbered_name(const std::string& text);

}  // namespace fringetwin
