// SPDX-License-Identifier: Apache-2.0
// Test support: the paper's rig (PAPER.md, Tables 1, 3, 4) and ideal decoded maps computed per pixel by ray
// casting in double, so that tests see the error of the correspondence alone.
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "measure/decode/decode.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure::test_tools {

/// Both cameras and the projector; world = left camera. `scale` shrinks the images (and focal lengths).
Twin paper_rig(double scale = 1.0);

/// Ray (world) -> distance along the unit direction of the first hit; nullopt = none.
using Scene =
    std::function<std::optional<double>(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)>;
Scene sphere_scene(const Eigen::Vector3d& center_mm, double radius_mm);
Scene plane_scene(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& normal);
Scene cylinder_scene(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& axis, double radius_mm);
/// Nearest hit of several.
Scene nearest(std::vector<Scene> scenes);

struct MapOptions {
  std::vector<Axis> axes = {Axis::x};
  bool shadows = false;   ///< pixels the projector does not see are invalid
  double noise_px = 0.0;  ///< Gaussian noise of the coordinate, also its stated sigma
  unsigned seed = 1;
};
/// What a perfect decoder would report for one camera.
CameraDecode ideal_decode(const Twin& twin, std::size_t camera, const Scene& scene,
                          const MapOptions& options = {});

/// World point that a pixel of the camera sees.
std::optional<Eigen::Vector3d> true_point(const Twin& twin, std::size_t camera, const Eigen::Vector2d& q_px,
                                          const Scene& scene);

}  // namespace fringetwin::measure::test_tools
