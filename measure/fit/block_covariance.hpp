// SPDX-License-Identifier: Apache-2.0
// Estimates the covariance of a least-squares fit whose residuals are correlated between neighbouring pixels.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <vector>

namespace fringetwin::measure {

/// Fewer blocks than this say nothing about correlation.
inline constexpr std::size_t kFewestBlocks = 12;

/// Returns the image block of each source pixel: squares of 32 px, or 16 or 8 px where fewer than 20 of the
/// larger ones hold points.
std::vector<int> image_blocks(const std::vector<Eigen::Vector2f>& q_px);

/// Sums over points: J^T J and J^T r.
struct BlockSum {
  explicit BlockSum(int parameters)
      : jtj(Eigen::MatrixXd::Zero(parameters, parameters)), jtr(Eigen::VectorXd::Zero(parameters)) {}
  /// One point: its residual and the derivatives by each parameter.
  void add(const double* row, double residual) {
    for (Eigen::Index j = 0; j < jtr.size(); ++j) {
      for (Eigen::Index i = 0; i < jtr.size(); ++i) jtj(i, j) += row[i] * row[j];
      jtr[j] += residual * row[j];
    }
  }

  Eigen::MatrixXd jtj;
  Eigen::VectorXd jtr;
};

/// Returns the matrix of s_i m_ij s_j.
Eigen::MatrixXd scaled_both_sides(const Eigen::MatrixXd& m, const Eigen::VectorXd& s);

/// Returns the covariance by the delete-a-block jackknife, one linear step per block: leaving out block b
/// moves the solution by d_b = (J^T J - J_b^T J_b)^-1 J_b^T r_b, and the covariance is (G-1)/G sum d_b d_b^T
/// (Efron 1982; Bell and McCaffrey 2002, "CR3"). No variance falls below that of independent residuals.
/// Unchanged when there are fewer than kFewestBlocks blocks or one of them alone determines the fit.
Eigen::MatrixXd block_covariance(const std::map<int, BlockSum>& blocks, const Eigen::MatrixXd& independent);

}  // namespace fringetwin::measure
