// SPDX-License-Identifier: Apache-2.0
#include "render/trace/adaptive_error.hpp"

#include <algorithm>
#include <cmath>

namespace fringetwin::render {

double panel_error(const std::array<double, 4>& g) {
  const double even = std::abs(g[0] - g[1] - g[2] + g[3]) / 24.0;
  const double odd = std::abs(g[3] - g[0] - std::sqrt(5.0) * (g[2] - g[1]));  // 0 for a straight line
  return 2.0 * even + 0.05 * odd;
}

double largest_error_to_keep(std::vector<double> errors, double budget, double cap) {
  std::ranges::sort(errors);  // NaN compares false: caught below
  double keep = -1.0;
  for (const double e : errors) {
    budget -= e * e;
    if (!(budget >= 0.0) || !(e <= cap)) break;
    keep = e;
  }
  return keep;
}

}  // namespace fringetwin::render
