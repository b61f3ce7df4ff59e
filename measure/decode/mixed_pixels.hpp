// SPDX-License-Identifier: Apache-2.0
// Leaves out the pixels that the part, or its light, fills only partly: their phase is right, but of another
// place than the pixel's centre.
#pragma once
#include <cstddef>

#include "measure/decode/decode_types.hpp"

namespace fringetwin::measure {

/// Returns how far the centroid of the light in a border pixel may be from its centre, px; `a0` is its
/// amplitude, a1 and a2 those of the next two pixels inwards.
double centroid_shift_px(double a0, double a1, double a2);

/// Returns what triangulation needs of a decode (coordinates, sigmas, flags), without the border pixels whose
/// phase is displaced by more than its own sigma. A border pixel has a neighbour without a coordinate; with
/// A0, A1, A2 the amplitudes from it inwards, a pixel filled to the share f = A0 / (2 A1 - A2) has its
/// centroid (1 - f)/2 px off, one with a falling amplitude (A1 - A0)/(12 A0) px (first moment of a linear
/// profile); times the local slope of the coordinate that is the displacement. The edge of the image is no
/// border: there the sensor ends, not the part. `n_left_out` is added to.
CameraDecode without_mixed_pixels(const CameraDecode& decode, std::size_t& n_left_out);

}  // namespace fringetwin::measure
