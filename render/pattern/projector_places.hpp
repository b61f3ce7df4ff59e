// SPDX-License-Identifier: Apache-2.0
// Tells where in the projector's image the light of a camera's pixels comes from: by fringes so wide that
// their phase is the place.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns the twin with the fringes that tell places, and nothing else that would change an image: no
/// response, field, halo, bounces or light of the room, and no factors, texture or vignetting. Needs a
/// projector.
Twin showing_places(const Twin& twin);

/// Returns the place, projector px, of a pixel in images of such a twin; any place where no light arrives.
Eigen::Vector2d place_in_projector_px(const std::vector<ImageF>& images, std::size_t pixel,
                                      const Projector& projector);

}  // namespace fringetwin::render
