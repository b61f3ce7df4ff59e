// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/triangulate.hpp"

#include <cmath>

#include "twin/lens/linear.hpp"

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
    const Eigen::Vector3d move = solve_symmetric(normal, right);
    if (!move.allFinite()) return std::nullopt;
    p += move;
    if (move.norm() < 1e-10 * (1.0 + p.norm())) return p;
  }
  return std::nullopt;
}

double aligned_rms_mm(const std::vector<Eigen::Vector3d>& a_mm, const std::vector<Eigen::Vector3d>& b_mm) {
  const Pose T = rigid_alignment(a_mm, b_mm);
  double sum = 0.0;
  for (std::size_t i = 0; i < a_mm.size(); ++i) sum += (T * a_mm[i] - b_mm[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a_mm.size()));
}

}  // namespace fringetwin::calib
