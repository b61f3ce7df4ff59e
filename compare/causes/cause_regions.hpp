// SPDX-License-Identifier: Apache-2.0
// Adds up what a twin leaves of the gray values over squares of pixels: errors that single values hide in
// their noise add up there.
#pragma once
#include <vector>

#include "compare/causes/sensitivity.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// Returns what a prediction leaves, with the gain and black level set, in the sums over squares of 8 x 8
/// kept pixels: their level, their contrast, the shift of their fringes (weights dE/dphase of the
/// prediction's own first harmonic), and the level of each image. Of what every pixel has of its own (`free`,
/// and a factor where the sensitivity has free factors) only what it leaves counts: of a level with an
/// offset, and of a contrast with both, nothing (n is 0). A row per kind, in this order.
std::vector<CauseRegion> cause_regions(const Sensitivity& sensitivity, const Fringes& fringes,
                                       const Sensitivity::Values& predicted,
                                       FreePerPixel free = FreePerPixel::nothing);

}  // namespace fringetwin::compare
