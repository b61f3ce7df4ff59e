// SPDX-License-Identifier: Apache-2.0
#include "render/trace/sample_table.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "render/base/quadrature.hpp"
#include "render/base/sobol.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {

std::vector<DiskPoint> disk_rule(int radial, int angles) {
  const GaussRule& rule = gauss_rule(radial);
  std::vector<DiskPoint> points;
  for (int i = 0; i < radial; ++i) {
    const double r = std::sqrt(0.5 * (1.0 + rule.nodes[i]));
    const double weight = 0.5 * rule.weights[i] / angles;
    for (int k = 0; k < angles; ++k) {
      // The rings are turned against each other, so that fewer projections on the fringe direction coincide.
      const double a = 2.0 * std::numbers::pi * (k + 0.5 * (i % 2)) / angles;
      points.push_back({r * std::cos(a), r * std::sin(a), weight});
    }
  }
  return points;
}

std::vector<DiskPoint> disk_rule_for_swing(double swing_rad) {
  // exp(i s r cos a): angular aliasing is J_m(s) for m angles, and the radial part a Bessel function
  // of r^2 that a few nodes integrate; both fall off faster than exponentially beyond s.
  const double swing = std::min(swing_rad, kLargestDiskSwingRad);
  const int angles = 6 + 2 * static_cast<int>(std::ceil(swing));
  const int radial = 3 + static_cast<int>(std::ceil(0.5 * swing));
  return disk_rule(radial, angles);
}

std::vector<gpu::vec4> gauss_samples(int samples, double pixel_fill, const std::vector<DiskPoint>& lens,
                                     double lens_radius_mm) {
  const auto n = static_cast<int>(std::lround(std::sqrt(static_cast<double>(samples))));
  FT_CHECK(n >= 1 && n * n == samples, "a Gauss rule has n x n samples");
  const GaussRule& rule = gauss_rule(n);
  std::vector<gpu::vec4> table;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const double dx = 0.5 * pixel_fill * rule.nodes[a], dy = 0.5 * pixel_fill * rule.nodes[b];
      const double weight = 0.25 * rule.weights[a] * rule.weights[b];
      const auto place = static_cast<float>(i + MOST_COLUMNS * j);
      if (lens.empty())
        table.push_back({static_cast<float>(dx), static_cast<float>(dy), static_cast<float>(weight), place});
      for (const DiskPoint& p : lens) {
        table.push_back(
            {static_cast<float>(dx), static_cast<float>(dy), static_cast<float>(weight * p.weight), place});
        table.push_back({static_cast<float>(p.x * lens_radius_mm), static_cast<float>(p.y * lens_radius_mm)});
      }
    }
  // A node's share is as wide as its weight says; laid side by side the shares fill the pixel, and each
  // contains its node (Chebyshev, Markov and Stieltjes' separation theorem).
  double end = -1.0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double half = 0.5 * pixel_fill, start = end;
    end += rule.weights[i];
    table.push_back({static_cast<float>(half * (start - rule.nodes[i])),
                     static_cast<float>(half * (end - rule.nodes[i])), 0.0F, 0.0F});
  }
  return table;
}

std::vector<gpu::uvec4> sobol_points(std::uint32_t n) {
  const std::array directions{sobol_directions(0), sobol_directions(1), sobol_directions(2),
                              sobol_directions(3)};
  std::vector<gpu::uvec4> points(n);
  for (std::uint32_t i = 0; i < n; ++i)
    points[i] = {sobol_coordinate(directions[0], i), sobol_coordinate(directions[1], i),
                 sobol_coordinate(directions[2], i), sobol_coordinate(directions[3], i)};
  return points;
}

Factors multi_jitter_factors(std::uint32_t n) {
  const auto root = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(n)));
  for (std::uint32_t c = root; 2 * c >= root && c > 0; --c)
    if (n % c == 0) return {c, n / c};
  const std::uint32_t columns = std::max(root, 1U);
  return {columns, (n + columns - 1) / columns};
}

}  // namespace fringetwin::render
