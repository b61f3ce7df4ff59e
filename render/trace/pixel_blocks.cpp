// SPDX-License-Identifier: Apache-2.0
#include "render/trace/pixel_blocks.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/scene/pack_scene.hpp"

namespace fringetwin::render {

std::vector<std::uint32_t> active_blocks(const Camera& camera, const PackedScene& scene,
                                         const LensTable& lens) {
  // A lens point sees an object at depth z displaced by up to lens radius * (1 + z/focus).
  const double lens_mm = lens_radius_mm(camera.optics);
  struct Cone {
    Eigen::Vector3d axis;
    double angle;
  };
  std::vector<Cone> cones;
  for (const BoundingSphere& b : scene.finite) {
    const double distance = b.center_mm.norm();
    const double spread =
        camera.optics ? lens_mm * (1.0 + (distance + b.radius_mm) / camera.optics->focus_distance_mm) : 0.0;
    const double radius = b.radius_mm * (1.0 + 1e-6) + spread;
    cones.push_back(
        {b.center_mm.normalized(), radius >= distance ? std::numbers::pi : std::asin(radius / distance)});
  }
  const int n = lens.blocks_x * lens.blocks_y;
  std::vector<unsigned char> active(n, scene.unbounded);
#pragma omp parallel for
  for (int k = 0; k < n; ++k) {
    const Eigen::Vector3d d = lens.block_cones[k].head<3>();
    for (std::size_t j = 0; j < cones.size() && !active[k]; ++j) {
      const double angle = std::atan2(d.cross(cones[j].axis).norm(), d.dot(cones[j].axis));
      active[k] = angle <= cones[j].angle + lens.block_cones[k][3];
    }
  }
  std::vector<std::uint32_t> blocks;
  for (int y = 0; y < lens.blocks_y; ++y)
    for (int x = 0; x < lens.blocks_x; ++x)
      if (active[y * lens.blocks_x + x])
        blocks.push_back(static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 16);
  return blocks;
}

std::vector<PixelRun> pixels_around(const std::vector<std::uint32_t>& blocks, int width_px, int height_px,
                                    int reach_px) {
  const int n_x = (width_px + BLOCK_WIDTH - 1) / BLOCK_WIDTH,
            n_y = (height_px + BLOCK_HEIGHT - 1) / BLOCK_HEIGHT;
  std::vector<unsigned char> inside(static_cast<std::size_t>(n_x) * n_y, 0);
  const auto is_inside = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < n_x && y < n_y && inside[static_cast<std::size_t>(y) * n_x + x];
  };
  for (const std::uint32_t block : blocks)
    inside[static_cast<std::size_t>(block >> 16) * n_x + (block & 0xffffU)] = 1;
  std::vector<PixelRun> runs;
  for (int y = 0; y < n_y; ++y)
    for (int x = 0; x < n_x; ++x) {
      if (is_inside(x, y)) continue;
      const bool left = is_inside(x - 1, y), right = is_inside(x + 1, y);
      for (int row = 0; row < BLOCK_HEIGHT && y * BLOCK_HEIGHT + row < height_px; ++row) {
        // what lies within reach above or below this row
        const int beside = row < reach_px ? y - 1 : row >= BLOCK_HEIGHT - reach_px ? y + 1 : y;
        const bool whole = is_inside(x, beside);
        const auto add = [&](int first, int n) {
          const int from = x * BLOCK_WIDTH + first, end = std::min(from + n, width_px);
          if (end > from) runs.push_back({from, y * BLOCK_HEIGHT + row, end - from});
        };
        if (whole) {
          add(0, BLOCK_WIDTH);
          continue;
        }
        if (left || is_inside(x - 1, beside)) add(0, reach_px);
        if (right || is_inside(x + 1, beside)) add(BLOCK_WIDTH - reach_px, reach_px);
      }
    }
  return runs;
}

}  // namespace fringetwin::render
