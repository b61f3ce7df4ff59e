// SPDX-License-Identifier: Apache-2.0
// Names what a field of a result may have besides its key and its value: a limit that a twin sets on it, and
// a column of a plain table on the page.
#pragma once
#include <limits>
#include <string>

namespace fringetwin::compare {

/// A limit that a twin may set in [limits] on the worst value over all rows.
struct Limit {
  enum class Worst { largest, smallest, farthest_from_one, largest_difference };
  std::string name;
  std::string meaning;  ///< says which value is held against the limit, with its unit
  Worst worst = Worst::largest;
  double highest = std::numeric_limits<double>::infinity();  ///< largest limit that makes sense
  /// True where a larger value is a better one: the limit is the least that passes.
  bool is_least() const { return worst == Worst::smallest; }
};

/// How a plain table of the page prints a field.
struct Column {
  enum Style { plain, fixed, signed_fixed, significant, with_sigma };
  std::string header = "";
  std::string unit = "";  ///< as printed below the header
  Style style = plain;
  int digits = 0;          ///< decimals of fixed and signed_fixed, significant ones of significant
  double factor = 1.0;     ///< 100 for per cent
  int place = 0;           ///< columns with a larger place stand further right than their field
  std::string sigma = "";  ///< with_sigma: key of what is printed behind ±; empty: the field's standard error
};

}  // namespace fringetwin::compare
