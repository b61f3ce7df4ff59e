// SPDX-License-Identifier: Apache-2.0
// Covariance of a least-squares fit whose residuals are correlated between neighbouring pixels.
#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

namespace fringetwin::measure {

/// Fewer blocks than this say nothing about correlation.
inline constexpr std::size_t kFewestBlocks = 12;

/// The image block of each source pixel: squares of 32 px, or 16 or 8 px where fewer than 20 of the larger
/// ones hold points.
std::vector<int> image_blocks(const std::vector<Eigen::Vector2f>& q_px);

/// Sums of one block: J^T J and J^T r of its points.
template <int M>
struct BlockSum {
  Eigen::Matrix<double, M, M> jtj = Eigen::Matrix<double, M, M>::Zero();
  Eigen::Matrix<double, M, 1> jtr = Eigen::Matrix<double, M, 1>::Zero();
};

/// Delete-a-block jackknife, one linear step per block: leaving out block b moves the solution by
/// d_b = (J^T J - J_b^T J_b)^-1 J_b^T r_b, and the covariance is (G-1)/G sum d_b d_b^T (Efron 1982; Bell and
/// McCaffrey 2002, "CR3"). No variance falls below that of independent residuals. Unchanged when there are
/// fewer than kFewestBlocks blocks or one of them alone determines the fit.
template <int M>
Eigen::Matrix<double, M, M> block_covariance(const std::map<int, BlockSum<M>>& blocks,
                                             const Eigen::Matrix<double, M, M>& independent) {
  using Matrix = Eigen::Matrix<double, M, M>;
  using Vector = Eigen::Matrix<double, M, 1>;
  if (blocks.size() < kFewestBlocks || !independent.allFinite()) return independent;
  Matrix total = Matrix::Zero();
  for (const auto& [id, b] : blocks) total += b.jtj;
  const Vector unit = total.diagonal().cwiseSqrt().cwiseInverse();
  Matrix sum = Matrix::Zero();
  for (const auto& [id, b] : blocks) {
    const Matrix rest = unit.asDiagonal() * (total - b.jtj) * unit.asDiagonal();
    const Eigen::LDLT<Matrix> ldlt(rest);
    if (ldlt.info() != Eigen::Success || !(ldlt.rcond() > 1e-13)) return independent;
    const Vector scaled_right = unit.cwiseProduct(b.jtr);
    const Vector scaled = ldlt.solve(scaled_right);
    const Vector moved = unit.cwiseProduct(scaled);
    sum += moved * moved.transpose();
  }
  const auto g = static_cast<double>(blocks.size());
  Matrix covariance = (g - 1.0) / g * sum;
  Vector raise;
  for (int j = 0; j < M; ++j)
    raise[j] = covariance(j, j) < independent(j, j) ? std::sqrt(independent(j, j) / covariance(j, j)) : 1.0;
  if (!raise.allFinite()) return independent;
  covariance = raise.asDiagonal() * covariance * raise.asDiagonal();
  return covariance;
}

}  // namespace fringetwin::measure
