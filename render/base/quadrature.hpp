// SPDX-License-Identifier: Apache-2.0
// Provides Gauss-Legendre quadrature rules on [-1, 1] in double precision.
#pragma once
#include <vector>

namespace fringetwin::render {

/// A rule of n nodes in (-1, 1), ascending, whose weights sum to 2; exact for polynomials of degree 2n-1.
struct GaussRule {
  std::vector<double> nodes, weights;
};

/// Returns the rule of n = 1 ... 256 nodes, computed once (Newton on the Legendre recurrence, to rounding).
/// Thread-safe.
const GaussRule& gauss_rule(int n);

}  // namespace fringetwin::render
