// SPDX-License-Identifier: Apache-2.0
#include "render/trace/pixel_blocks.hpp"

#include <Eigen/Geometry>
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

}  // namespace fringetwin::render
