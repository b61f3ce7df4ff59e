// SPDX-License-Identifier: Apache-2.0
#include "measure/points/tangent_plane.hpp"

#include <cmath>

namespace fringetwin::measure {

std::optional<TangentPlane> TangentSums::plane() const {
  const double uu = uu_ - u_ * u_ / n_, uv = uv_ - u_ * v_ / n_, vv = vv_ - v_ * v_ / n_;
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-6 * uu * vv)) return std::nullopt;
  const Eigen::Vector3d cu = up_ - u_ / n_ * p_, cv = vp_ - v_ / n_ * p_;
  const Eigen::Vector3d a = (vv * cu - uv * cv) / determinant, b = (uu * cv - uv * cu) / determinant;
  return TangentPlane{(p_ - u_ * a - v_ * b) / n_, a, b, std::sqrt(vv / determinant),
                      std::sqrt(uu / determinant)};
}

}  // namespace fringetwin::measure
