// SPDX-License-Identifier: Apache-2.0
// Gauss-Legendre rules in double precision.
#pragma once
#include <vector>

namespace fringetwin::render {

/// Nodes in (-1, 1), ascending; weights sum to 2. Exact for polynomials of degree 2n-1.
struct GaussRule {
  std::vector<double> nodes, weights;
};

/// n = 1 ... 256, each computed once (Newton on the Legendre recurrence, to rounding). Thread-safe.
const GaussRule& gauss_rule(int n);

}  // namespace fringetwin::render
