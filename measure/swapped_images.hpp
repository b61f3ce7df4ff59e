// SPDX-License-Identifier: Apache-2.0
// Tells whether the images of two cameras are exchanged, mirrored or upside down: the reading of them is
// named with which the rays of both cameras meet (docs/metrics/measure.md, "Doubts about the description").
#pragma once
#include <optional>
#include <string>

#include "measure/measurement.hpp"

namespace fringetwin::measure {

/// Returns a sentence where a stereo rig rejects many pixels of its captures and another reading of the
/// images hardly any; nothing, and at no cost, where most pixels have points and few are rejected.
std::optional<std::string> swapped_images(const Twin& twin, const Measurement& measured);

}  // namespace fringetwin::measure
