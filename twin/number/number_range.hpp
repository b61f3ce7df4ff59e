// SPDX-License-Identifier: Apache-2.0
// Which values a number in one of our files may have.
#pragma once
#include <limits>

namespace fringetwin {

/// Besides the range that a quantity has by nature there is one of sense: the renderer computes in float,
/// where 1e300 is infinite and 1e-300 is zero.
struct NumberRange {
  double min = -std::numeric_limits<double>::max();
  double max = std::numeric_limits<double>::max();
  bool min_excluded = false;
  bool max_excluded = false;
  double smallest = 0.0;  ///< of a quantity > 0: nothing below
  double largest = 1e9;   ///< no absolute value above
  bool contains(double value) const {
    return (min_excluded ? value > min : value >= min) && (max_excluded ? value < max : value <= max);
  }
  static NumberRange any_size() { return {.largest = std::numeric_limits<double>::max()}; }
  static NumberRange positive(double smallest = 1e-9, double largest = 1e9) {
    return {.min = 0.0, .min_excluded = true, .smallest = smallest, .largest = largest};
  }
  static NumberRange not_negative() { return {.min = 0.0}; }
  static NumberRange between(double lo, double hi) { return {.min = lo, .max = hi}; }
};

}  // namespace fringetwin
