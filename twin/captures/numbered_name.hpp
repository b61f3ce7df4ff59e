// SPDX-License-Identifier: Apache-2.0
// A file name with a number, such as "left/%04d.png": made from the number, and the number read from it.
#pragma once
#include <optional>
#include <string>

namespace fringetwin {

struct NumberedName {
  std::string before, after;
  int digits = 0;  ///< at least so many, with leading zeros
  std::string operator()(int number) const;
  /// Returns the number that gives this name; nullopt for a name of another form.
  std::optional<int> number_of(const std::string& name) const;
};

/// Returns the name that the text describes; nullopt unless the text has one number, %d or %04d, and no other
/// %, nor ".." behind it, which would give all numbers one name.
std::optional<NumberedName> parse_numbered_name(const std::string& text);

}  // namespace fringetwin
