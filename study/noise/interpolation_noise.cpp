// SPDX-License-Identifier: Apache-2.0
#include "study/noise/interpolation_noise.hpp"

#include <Eigen/LU>
#include <cmath>
#include <utility>
#include <vector>

#include "render/base/quadrature.hpp"

namespace fringetwin::study {
namespace {

constexpr double kSupport = 4.0;  ///< of the covariance, px

/// Weight of a pixel for a value read `t` px beside it.
double kernel(double t) {
  t = std::abs(t);
  if (t < 1.0) return (1.0 - t * t) * (2.0 - t) / 2.0;
  if (t < 2.0) return (1.0 - t) * (2.0 - t) * (3.0 - t) / 6.0;
  return 0.0;
}

/// Integral of kernel(t) kernel(t + d) over all t: polynomials of degree 6 between the breaks, for which
/// Gauss quadrature with four points is exact.
double integrate(double d) {
  const render::GaussRule& rule = render::gauss_rule(4);
  const double fraction = d - std::floor(d);
  double sum = 0.0;
  for (int i = -7; i < 3; ++i)
    for (const auto& [from, to] : {std::pair(i + 0.0, i + 1.0 - fraction), {i + 1.0 - fraction, i + 1.0}})
      for (std::size_t k = 0; k < rule.nodes.size(); ++k) {
        const double t = 0.5 * (from + to) + 0.5 * (to - from) * rule.nodes[k];
        sum += 0.5 * (to - from) * rule.weights[k] * kernel(t) * kernel(t + d);
      }
  return sum;
}

constexpr int kPerPixel = 64;  ///< samples of the table; linear between them, within 1e-4

std::vector<double> covariance_table() {
  std::vector<double> table;
  for (int i = 0; i <= kPerPixel * static_cast<int>(kSupport) + 1; ++i)
    table.push_back(integrate(static_cast<double>(i) / kPerPixel));
  return table;
}

}  // namespace

double interpolation_covariance(double distance_px) {
  static const std::vector<double> table = covariance_table();
  const double at = std::abs(distance_px) * kPerPixel;
  if (at >= kSupport * kPerPixel) return 0.0;
  const auto i = static_cast<std::size_t>(at);
  return table[i] + (at - static_cast<double>(i)) * (table[i + 1] - table[i]);
}

double lattice_variance(const Eigen::Matrix2d& step_px) {
  const double pixels = std::abs(step_px.determinant());
  constexpr double kMany = 16.0, kMost = 1e4;  // points of a pixel; more are not counted one by one
  const bool dense = step_px.colwise().norm().maxCoeff() <= 1.0;
  if (!(pixels * (dense ? kMany : kMost) > 1.0)) return 1.0 / pixels;
  const Eigen::Matrix2d inverse = step_px.inverse();
  const int columns = static_cast<int>(kSupport * inverse.row(0).lpNorm<1>()),
            rows = static_cast<int>(kSupport * inverse.row(1).lpNorm<1>());
  double sum = 0.0;
  for (int i = -columns; i <= columns; ++i)
    for (int j = -rows; j <= rows; ++j) {
      const Eigen::Vector2d d = step_px * Eigen::Vector2d(i, j);
      sum += interpolation_covariance(d.x()) * interpolation_covariance(d.y());
    }
  return sum;
}

}  // namespace fringetwin::study
