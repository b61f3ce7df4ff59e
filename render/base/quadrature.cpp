// SPDX-License-Identifier: Apache-2.0
#include "render/base/quadrature.hpp"

#include <array>
#include <cmath>
#include <mutex>
#include <numbers>

#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr int kLargestRule = 256;

GaussRule make_rule(int n) {
  GaussRule rule;
  rule.nodes.resize(n);
  rule.weights.resize(n);
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
    double derivative = 1.0;
    for (int iteration = 0; iteration < 20; ++iteration) {
      double p0 = 1.0, p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      derivative = n * (x * p1 - p0) / (x * x - 1.0);
      const double step = p1 / derivative;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    if (2 * i + 1 == n) x = 0.0;
    rule.nodes[i] = x;
    rule.weights[i] = 2.0 / ((1.0 - x * x) * derivative * derivative);
  }
  return rule;
}

}  // namespace

const GaussRule& gauss_rule(int n) {
  FT_CHECK(n >= 1 && n <= kLargestRule, "Gauss-Legendre rules go from 1 to 256 nodes");
  static std::array<GaussRule, kLargestRule> rules;
  static std::array<std::once_flag, kLargestRule> made;
  const auto i = static_cast<std::size_t>(n - 1);
  std::call_once(made[i], [&] { rules[i] = make_rule(n); });
  return rules[i];
}

}  // namespace fringetwin::render
