// SPDX-License-Identifier: Apache-2.0
// Finds phase-step images that show the same pattern, though no two of the sequence do.
#pragma once
#include <utility>
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::measure {

/// Returns pairs (earlier, later) of image numbers of one direction, next or next but one in the sequence,
/// that differ by far less than two neighbouring steps do. Two pitches may look alike over a short range of
/// the projector: only where the decode is contradicted, too, is an image repeated. `reached`: the pixels
/// that count.
std::vector<std::pair<int, int>> repeated_images(const CameraImages& images, const Fringes& fringes,
                                                 const ImageU8& reached);

}  // namespace fringetwin::measure
