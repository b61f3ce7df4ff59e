// SPDX-License-Identifier: Apache-2.0
// Returns how far the picture of a place on the board moves when the place does.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "twin/lens/lens.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::calib {

/// d(picture, px)/d(place in the board's plane, mm) at p_board_mm; nullopt where the lens does not project
/// it. `q_px`: its picture, if wanted.
inline std::optional<Eigen::Matrix2d> board_gradient(const Lens& lens, const Pose& T_device_board,
                                                     const Eigen::Vector3d& p_board_mm,
                                                     Eigen::Vector2d* q_px = nullptr) {
  Eigen::Matrix<double, 2, 3> dq_dp;
  const auto q = lens.project(T_device_board * p_board_mm, &dq_dp);
  if (!q) return std::nullopt;
  if (q_px) *q_px = *q;
  return Eigen::Matrix2d(dq_dp * T_device_board.rotation.leftCols<2>());
}

}  // namespace fringetwin::calib
