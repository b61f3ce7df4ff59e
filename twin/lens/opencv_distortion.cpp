// SPDX-License-Identifier: Apache-2.0
#include "twin/lens/opencv_distortion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "twin/number/polynomial.hpp"

namespace fringetwin {

Eigen::Vector2d distort(const OpenCvDistortion& k, const Eigen::Vector2d& undistorted,
                        Eigen::Matrix2d* jacobian) {
  const double x = undistorted.x(), y = undistorted.y(), u = x * x + y * y;
  const double numerator = 1.0 + u * (k[0] + u * (k[1] + u * k[4]));
  const double denominator = 1.0 + u * (k[5] + u * (k[6] + u * k[7]));
  const double radial = numerator / denominator;
  const double p1 = k[2], p2 = k[3];
  Eigen::Vector2d distorted(x * radial + 2.0 * p1 * x * y + p2 * (u + 2.0 * x * x) + u * (k[8] + u * k[9]),
                            y * radial + p1 * (u + 2.0 * y * y) + 2.0 * p2 * x * y + u * (k[10] + u * k[11]));
  if (jacobian) {
    const double d_numerator = k[0] + u * (2.0 * k[1] + u * 3.0 * k[4]);
    const double d_denominator = k[5] + u * (2.0 * k[6] + u * 3.0 * k[7]);
    const double d_radial_du = (d_numerator - radial * d_denominator) / denominator;
    const double prism_x = k[8] + 2.0 * u * k[9], prism_y = k[10] + 2.0 * u * k[11];  // d/du
    const double mixed = 2.0 * x * y * d_radial_du + 2.0 * (p1 * x + p2 * y);
    (*jacobian)(0, 0) = radial + 2.0 * x * x * d_radial_du + 2.0 * p1 * y + 6.0 * p2 * x + 2.0 * x * prism_x;
    (*jacobian)(0, 1) = mixed + 2.0 * y * prism_x;
    (*jacobian)(1, 0) = mixed + 2.0 * x * prism_y;
    (*jacobian)(1, 1) = radial + 2.0 * y * y * d_radial_du + 6.0 * p1 * y + 2.0 * p2 * x + 2.0 * y * prism_y;
  }
  return distorted;
}

double max_invertible_radius(const OpenCvDistortion& k) {
  // Polynomials in r (not r^2: the tangential bound is odd). With f = r N/D:
  //   f'(r) D^2 = (N + r N') D - r N D',   (f/r) D^2 = N D   (' = d/dr)
  const Polynomial N{1.0, 0.0, k[0], 0.0, k[1], 0.0, k[4]};
  const Polynomial D{1.0, 0.0, k[5], 0.0, k[6], 0.0, k[7]};
  const Polynomial r{0.0, 1.0};
  const Polynomial radial_eigenvalue =
      subtract(multiply(add(N, multiply(r, derivative(N))), D), multiply(r, multiply(N, derivative(D))));
  const Polynomial angular_eigenvalue = multiply(N, D);
  const Polynomial other_terms{0.0, 6.0 * std::hypot(k[2], k[3]) + 2.0 * std::hypot(k[8], k[10]), 0.0,
                               4.0 * std::hypot(k[9], k[11])};
  const Polynomial bound = multiply(multiply(D, D), other_terms);

  constexpr double kNoLimitBeyond = 1e6;
  double limit = std::numeric_limits<double>::infinity();
  for (const Polynomial& p : {D, subtract(radial_eigenvalue, bound), subtract(angular_eigenvalue, bound)}) {
    if (const auto root = smallest_positive_root(p, kNoLimitBeyond)) limit = std::min(limit, *root);
  }
  return limit;
}

}  // namespace fringetwin
