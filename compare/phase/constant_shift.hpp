// SPDX-License-Identifier: Apache-2.0
// Finds real fringes that lie beside the twin's by one and the same distance all over the image, as they do
// where the pattern is described with another origin than it was shown with.
#pragma once
#include <optional>

#include "measure/measurement.hpp"

namespace fringetwin::compare {

/// Returns the median of x_real - x_sim in projector pixels where it is a fifth of the finest pitch or more
/// and 95 % of the pixels valid on both sides are within 5 % of a pitch from it; fringe orders count, so that
/// half a period is found, too. Nothing on fewer than 200 pixels.
std::optional<double> constant_shift_px(const measure::DirectionDecode& real,
                                        const measure::DirectionDecode& simulated);

}  // namespace fringetwin::compare
