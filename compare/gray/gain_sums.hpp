// SPDX-License-Identifier: Apache-2.0
// Adds up, in one pass over all gray values of a camera, the sums that the gain's M-estimator needs.
#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "compare/gray/gray_pair.hpp"

namespace fringetwin::compare {

/// Linear model y = a + b (E - e_center); parameters p = (a, b). Residual r = y - prediction,
/// psi(r) = clamp(r, -threshold, threshold).
struct GainModel {
  double a = 0.0, b = 0.0, e_center = 0.0, threshold_dn = 1.0;
};

/// The sums of one pass.
struct GainSums {
  std::uint64_t n = 0, n_beyond = 0;                            ///< values; |r| >= threshold
  Eigen::Vector2d score = Eigen::Vector2d::Zero();              ///< sum psi x, x = (1, E - e_center)
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();        ///< sum psi' x x^T
  Eigen::Matrix2d score_independent = Eigen::Matrix2d::Zero();  ///< sum psi^2 x x^T
  Eigen::Matrix2d score_blocks = Eigen::Matrix2d::Zero();       ///< sum over blocks (sum psi x)(...)^T
  Eigen::Matrix2d gram = Eigen::Matrix2d::Zero();               ///< sum x x^T
  std::uint64_t n_blocks = 0;
  double sum_y = 0.0, sum_y2 = 0.0, sum_r2 = 0.0, sum_before2 = 0.0;
};

/// Sums in parallel over bands of blocks; the result does not depend on the number of threads.
GainSums sum_gain(const GrayPair& pair, const UsableRange& usable, const GainModel& model);

}  // namespace fringetwin::compare
