// SPDX-License-Identifier: Apache-2.0
// Tells whether the images of two cameras are exchanged, mirrored or upside down: the reading of them is
// named with which the rays of both cameras meet (docs/metrics/measure.md, "Doubts about the description").
#pragma once
#include <optional>
#include <string>

#include "measure/measurement.hpp"

namespace fringetwin::measure {

/// Returns whether a stereo rig rejects many of the pixels with a match, or has points at less than half of
/// the pixels that both cameras can see. What one camera alone sees does not count. Asks a grid of pixels.
bool rays_miss_each_other(const Twin& twin, const Measurement& measured);

/// Returns a sentence where rays_miss_each_other() and another reading of the images rejects hardly any;
/// nothing, and at no cost, elsewhere. Each of ten readings is triangulated in a few bands of rows.
std::optional<std::string> swapped_images(const Twin& twin, const Measurement& measured);

}  // namespace fringetwin::measure
