// SPDX-License-Identifier: Apache-2.0
// Shows the scene fringes of a full swing in place of a twin's own, so that one trace has what waves of their
// pitches bring to each pixel.
#pragma once
#include <vector>

#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns the twin under a linear and steady projector, with its blur and halo, and without other light. Its
/// images are three steps of each pitch, mean and amplitude kUnitLevel.
Twin showing_fringes(const Twin& twin, std::vector<DirectionFringes> directions);
inline constexpr double kUnitLevel = 0.5;

}  // namespace fringetwin::render
