// SPDX-License-Identifier: Apache-2.0
#include "twin/number/polynomial.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fringetwin {
namespace {

Polynomial combine(const Polynomial& a, const Polynomial& b, double factor_b) {
  Polynomial sum(std::max(a.size(), b.size()), 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) sum[i] += a[i];
  for (std::size_t i = 0; i < b.size(); ++i) sum[i] += factor_b * b[i];
  return sum;
}

/// p takes values of opposite sign at low and high.
double bisect(const Polynomial& p, double low, double high) {
  const bool low_positive = evaluate(p, low) > 0.0;
  for (;;) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) return middle;
    ((evaluate(p, middle) > 0.0) == low_positive ? low : high) = middle;
  }
}

/// |p(x)| is not distinguishable from 0 in double arithmetic.
bool is_zero_within_rounding(const Polynomial& p, double x) {
  double scale = 0.0;
  for (auto c = p.rbegin(); c != p.rend(); ++c) scale = scale * std::abs(x) + std::abs(*c);
  return std::abs(evaluate(p, x)) <=
         4.0 * static_cast<double>(p.size()) * std::numeric_limits<double>::epsilon() * scale;
}

/// Sorted roots in (0, limit]: between neighbouring extrema p is monotone, so a sign change there
/// holds exactly one root. The extrema are the roots of the derivative.
std::vector<double> positive_roots(const Polynomial& p, double limit) {
  std::size_t degree = p.size();
  while (degree > 0 && p[degree - 1] == 0.0) --degree;
  if (degree <= 1) return {};
  const Polynomial trimmed(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(degree));
  std::vector<double> stops = positive_roots(derivative(trimmed), limit);
  stops.push_back(limit);

  std::vector<double> roots;
  double low = 0.0;
  for (const double high : stops) {
    const double value_low = evaluate(trimmed, low), value_high = evaluate(trimmed, high);
    if (is_zero_within_rounding(trimmed, high)) {
      roots.push_back(high);
    } else if ((value_low < 0.0 && value_high > 0.0) || (value_low > 0.0 && value_high < 0.0)) {
      roots.push_back(bisect(trimmed, low, high));
    }
    low = high;
  }
  return roots;
}

}  // namespace

double evaluate(const Polynomial& p, double x) {
  double value = 0.0;
  for (auto c = p.rbegin(); c != p.rend(); ++c) value = value * x + *c;
  return value;
}

Polynomial derivative(const Polynomial& p) {
  Polynomial d;
  for (std::size_t i = 1; i < p.size(); ++i) d.push_back(static_cast<double>(i) * p[i]);
  return d;
}

Polynomial multiply(const Polynomial& a, const Polynomial& b) {
  if (a.empty() || b.empty()) return {};
  Polynomial product(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) product[i + j] += a[i] * b[j];
  return product;
}

Polynomial add(const Polynomial& a, const Polynomial& b) { return combine(a, b, 1.0); }
Polynomial subtract(const Polynomial& a, const Polynomial& b) { return combine(a, b, -1.0); }

std::optional<double> smallest_positive_root(const Polynomial& p, double limit) {
  const std::vector<double> roots = positive_roots(p, limit);
  if (roots.empty()) return std::nullopt;
  return roots.front();
}

}  // namespace fringetwin
