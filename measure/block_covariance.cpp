// SPDX-License-Identifier: Apache-2.0
#include "measure/block_covariance.hpp"

#include <set>

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

}  // namespace fringetwin::measure
