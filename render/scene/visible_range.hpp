// SPDX-License-Identifier: Apache-2.0
// Finds how near to a camera and how far from it the surfaces in its view may lie; unbounded shapes count
// where the view meets them.
#pragma once
#include "render/scene/scene.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

struct VisibleRange {
  double z_min_mm, z_max_mm;  ///< depths in the camera's frame, > 0; empty (min > max) with nothing in view
  double far_mm = 0.0;        ///< largest distance from the camera
};

/// Returns the range of depth, never narrower than the truth but for what a view of 33 x 33 rays misses of
/// the curvature of a plane or cylinder between them. Meshes and spheres count with their bounding spheres,
/// where these touch the view.
VisibleRange visible_range(const Camera& camera, const PackedScene& scene);

}  // namespace fringetwin::render
