// SPDX-License-Identifier: Apache-2.0
// Directions from a place of a surface, for the reference renderer.
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace fringetwin::render {

/// Returns a normal or its opposite, whichever lies on a side.
inline Eigen::Vector3d on_side(const Eigen::Vector3d& normal, const Eigen::Vector3d& side) {
  return normal.dot(side) < 0.0 ? Eigen::Vector3d(-normal) : normal;
}

/// Directions over the hemisphere around the side of a shading normal that a geometric normal faces, by the
/// cosine: sin^2 of the polar angle is uniform.
class Hemisphere {
 public:
  Hemisphere(const Eigen::Vector3d& shading, const Eigen::Vector3d& normal)
      : N_(on_side(shading, normal)), T_(N_.unitOrthogonal()), B_(N_.cross(T_)) {}
  Eigen::Vector3d direction(double sine2, double angle) const {
    return std::sqrt(sine2) * (std::cos(angle) * T_ + std::sin(angle) * B_) + std::sqrt(1.0 - sine2) * N_;
  }

 private:
  Eigen::Vector3d N_, T_, B_;
};

}  // namespace fringetwin::render
