// SPDX-License-Identifier: Apache-2.0
// Tells how rough the surfaces are that an image sees, as measured ones are: by how much the normal and the
// place of a pixel differ from the mean of two pixels on both sides of it. Curvature cancels there.
#pragma once
#include <map>

#include "render/indirect/seen_image.hpp"

namespace fringetwin::render {

/// Medians over a surface.
struct Roughness {
  float angle_rad = 0.0F;
  float out_of_plane = 0.0F;  ///< in parts of the distance
};

/// Returns the roughness of each primitive that enough pixels see; the two pixels are `step_px` away.
std::map<int, Roughness> roughness_of(const SeenImage& seen, int step_px);

/// Returns the limits of one surface for a place: no narrower than `limits`, and wide enough for most of what
/// its own surface does.
SurfaceLimits limits_for(const SurfacePlace& place, const SurfaceLimits& limits,
                         const std::map<int, Roughness>& roughness);

}  // namespace fringetwin::render
