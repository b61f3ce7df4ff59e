// SPDX-License-Identifier: Apache-2.0
// Real polynomials, given by their coefficients with the lowest power first: values, sums, products,
// derivative and the smallest positive root.
#pragma once
#include <optional>
#include <vector>

namespace fringetwin {

using Polynomial = std::vector<double>;

double evaluate(const Polynomial& p, double x);
Polynomial derivative(const Polynomial& p);
Polynomial multiply(const Polynomial& a, const Polynomial& b);
Polynomial add(const Polynomial& a, const Polynomial& b);
Polynomial subtract(const Polynomial& a, const Polynomial& b);

/// Returns the smallest root in (0, limit], to double rounding; a place where p touches zero within its
/// rounding error counts. nullopt when there is none.
std::optional<double> smallest_positive_root(const Polynomial& p, double limit);

}  // namespace fringetwin
