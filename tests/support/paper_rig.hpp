// SPDX-License-Identifier: Apache-2.0
// Makes twins in memory for the tests: the paper's rig (its Tables 1, 3, 4) and crops of it.
#pragma once
#include <string>
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::testing {

/// Two cameras 1440x1080, projector 1280x720, vertical fringes 13/14/15 px in 4 steps, intensity 40,
/// 8 bit with gain 20 DN (a white Lambertian surface of albedo 0.8 stays below 255); no objects.
/// Extrinsics read as rotation vectors.
Twin paper_rig();

/// Adds an object and returns the twin, for chains.
Twin with_object(Twin twin, const std::string& name, Shape shape, Material material = {});

SphereShape ideal_sphere();     ///< R 5 mm at (0, 0, 250)
SphereShape physical_sphere();  ///< Table 5: R 19.065 mm at (6.567, -5.497, 270.634)
PlaneShape frontal_plane(double z_mm = 300.0);
PlaneShape tilted_plane();
CylinderShape upright_cylinder();  ///< R 12 mm, leaning, in front of both cameras

/// Returns the same camera seeing only the window x0...x0+width, y0...y0+height: pixel (0,0) of the crop is
/// pixel (x0, y0) of the whole image. Perspective lens models only.
Camera crop(const Camera& camera, int x0, int y0, int width, int height);
/// Returns the twin with every camera cropped around the projection of a world point.
Twin crop_around(Twin twin, const Eigen::Vector3d& point_world_mm, int width, int height);

/// Reduces the twin to camera `index`.
Twin only_camera(Twin twin, std::size_t index);

/// Returns the paper's rig with its left camera alone, cropped around the projection of a world point.
inline Twin left_window(const Eigen::Vector3d& point_world_mm, int width, int height) {
  return crop_around(only_camera(paper_rig(), 0), point_world_mm, width, height);
}

/// Returns such a window on two walls at right angles, "left_wall" and "right_wall", that meet along y behind
/// (0, 0, 300).
Twin window_on_a_corner(double diffuse, int width, int height);

/// Returns the paper's rig with its physical sphere as "ball", each camera cropped to a window that it fills.
inline Twin window_on_the_sphere(int width, int height) {
  const SphereShape ball = physical_sphere();
  return crop_around(with_object(paper_rig(), "ball", ball), ball.center_mm, width, height);
}

}  // namespace fringetwin::testing
