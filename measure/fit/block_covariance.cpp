// SPDX-License-Identifier: Apache-2.0
#include "measure/fit/block_covariance.hpp"

#include <cmath>
#include <set>

#include "twin/lens/linear.hpp"

namespace fringetwin::measure {

std::vector<int> image_blocks(const std::vector<Eigen::Vector2f>& q_px) {
  constexpr std::size_t kEnoughBlocks = 20;
  constexpr int kRow = 1 << 15;  // more blocks than any image has side by side
  std::vector<int> block(q_px.size());
  for (const int side : {32, 16, 8}) {
    std::set<int> used;
    for (std::size_t i = 0; i < q_px.size(); ++i) {
      const int bx = static_cast<int>(std::lround(q_px[i].x())) / side;
      const int by = static_cast<int>(std::lround(q_px[i].y())) / side;
      block[i] = by * kRow + bx;
      used.insert(block[i]);
    }
    if (used.size() >= kEnoughBlocks) break;
  }
  return block;
}

Eigen::MatrixXd scaled_both_sides(const Eigen::MatrixXd& m, const Eigen::VectorXd& s) {
  Eigen::MatrixXd out = m;
  for (Eigen::Index j = 0; j < m.cols(); ++j)
    for (Eigen::Index i = 0; i < m.rows(); ++i) out(i, j) *= s[i] * s[j];
  return out;
}

Eigen::MatrixXd block_covariance(const std::map<int, BlockSum>& blocks, const Eigen::MatrixXd& independent) {
  if (blocks.size() < kFewestBlocks || !independent.allFinite()) return independent;
  const Eigen::Index m = independent.rows();
  BlockSum total(static_cast<int>(m));
  for (const auto& [id, b] : blocks) total.jtj += b.jtj;
  const Eigen::VectorXd unit = total.jtj.diagonal().cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(m, m);
  for (const auto& [id, b] : blocks) {
    const SymmetricFactor rest(scaled_both_sides(total.jtj - b.jtj, unit));
    if (!(rest.rcond() > 1e-13)) return independent;
    const Eigen::VectorXd right = unit.cwiseProduct(b.jtr);
    const Eigen::VectorXd scaled = rest.solve(right);
    const Eigen::VectorXd moved = unit.cwiseProduct(scaled);
    for (Eigen::Index j = 0; j < m; ++j) sum.col(j) += moved[j] * moved;
  }
  const auto g = static_cast<double>(blocks.size());
  const Eigen::MatrixXd covariance = (g - 1.0) / g * sum;
  Eigen::VectorXd raise(m);
  for (Eigen::Index j = 0; j < m; ++j)
    raise[j] = covariance(j, j) < independent(j, j) ? std::sqrt(independent(j, j) / covariance(j, j)) : 1.0;
  if (!raise.allFinite()) return independent;
  return scaled_both_sides(covariance, raise);
}

}  // namespace fringetwin::measure
