// SPDX-License-Identifier: Apache-2.0
#include "measure/points/point_grid.hpp"

#include <cmath>

namespace fringetwin::measure {

Image<int> point_grid(const PointCloud& cloud, int width_px, int height_px) {
  Image<int> grid(width_px, height_px, -1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const long x = std::lround(cloud.q_cam_px[i].x()), y = std::lround(cloud.q_cam_px[i].y());
    if (x < 0 || y < 0 || x >= width_px || y >= height_px) continue;
    grid(static_cast<int>(x), static_cast<int>(y)) = static_cast<int>(i);
  }
  return grid;
}

}  // namespace fringetwin::measure
