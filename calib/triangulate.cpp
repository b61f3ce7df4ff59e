// SPDX-License-Identifier: Apache-2.0
#include "calib/triangulate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "twin/errors.hpp"

namespace fringetwin::calib {

std::optional<Eigen::Vector3d> triangulate(const std::vector<Lens>& lenses,
                                           const std::vector<Pose>& T_device_ref,
                                           const std::vector<Eigen::Vector2d>& q_px,
                                           const Eigen::Vector3d& start_mm) {
  Eigen::Vector3d p = start_mm;
  constexpr int kSteps = 20;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t d = 0; d < lenses.size(); ++d) {
      Eigen::Matrix<double, 2, 3> g;
      const auto q = lenses[d].project(T_device_ref[d] * p, &g);
      if (!q) return std::nullopt;
      const Eigen::Matrix<double, 2, 3> J = g * T_device_ref[d].rotation;
      normal += J.transpose() * J;
      right += J.transpose() * (q_px[d] - *q);
    }
    const Eigen::Vector3d move = normal.ldlt().solve(right);
    if (!move.allFinite()) return std::nullopt;
    p += move;
    if (move.norm() < 1e-10 * (1.0 + p.norm())) return p;
  }
  return std::nullopt;
}

double aligned_rms_mm(const std::vector<Eigen::Vector3d>& a_mm, const std::vector<Eigen::Vector3d>& b_mm) {
  FT_CHECK(a_mm.size() == b_mm.size() && a_mm.size() >= 3, "alignment needs 3 pairs");
  const auto n = static_cast<Eigen::Index>(a_mm.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = a_mm[static_cast<std::size_t>(i)];
    b.col(i) = b_mm[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3Xd left =
      (T.topLeftCorner<3, 3>() * a).colwise() + Eigen::Vector3d(T.topRightCorner<3, 1>()) - b;
  return std::sqrt(left.squaredNorm() / static_cast<double>(n));
}

}  // namespace fringetwin::calib
