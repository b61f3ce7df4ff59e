// SPDX-License-Identifier: Apache-2.0
// Makes the rig of datasets/paper-sphere (Tables 1, 3, 4 of its paper) in any size, and ideal decoded maps
// computed per pixel by ray casting in double, so that tests see the error of the correspondence alone.
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "measure/decode/decode.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

/// Returns both cameras and the projector; world = left camera. `scale` shrinks the images (and focal
/// lengths).
Twin scaled_paper_rig(double scale = 1.0);

/// Ray (world) -> distance along the unit direction of the first hit; nullopt = none.
using RaySurface =
    std::function<std::optional<double>(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)>;
RaySurface sphere_surface(const Eigen::Vector3d& center_mm, double radius_mm);
RaySurface plane_surface(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& normal);
RaySurface cylinder_surface(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& axis, double radius_mm);
/// Nearest hit of several.
RaySurface nearest(std::vector<RaySurface> scenes);

struct MapOptions {
  std::vector<Axis> axes = {Axis::x};
  bool shadows = false;   ///< pixels the projector does not see are invalid
  double noise_px = 0.0;  ///< Gaussian noise of the coordinate, also its stated sigma
  unsigned seed = 1;
};
/// Returns what a perfect decoder would report for one camera.
measure::CameraDecode ideal_decode(const Twin& twin, std::size_t camera, const RaySurface& scene,
                                   const MapOptions& options = {});

/// World point that a pixel of the camera sees.
std::optional<Eigen::Vector3d> true_point(const Twin& twin, std::size_t camera, const Eigen::Vector2d& q_px,
                                          const RaySurface& scene);

}  // namespace fringetwin::testing
