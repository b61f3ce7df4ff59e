// SPDX-License-Identifier: Apache-2.0
// Adds up what a twin leaves of the gray values over squares of pixels: errors that single values hide in
// their noise add up there.
#pragma once
#include <vector>

#include "compare/causes/sensitivity.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// Returns what a twin leaves, with the gain and black level set, in the sums over squares of 8 x 8 kept
/// pixels: their level, their contrast, the shift of their fringes (weights dE/dphase of the prediction's own
/// first harmonic), and the level of each image. Where every pixel has a brightness of its own, only what
/// that leaves counts. A row per kind, in this order.
std::vector<CauseRegion> cause_regions(const Sensitivity& sensitivity, const Twin& twin);

}  // namespace fringetwin::compare
