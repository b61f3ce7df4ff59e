// SPDX-License-Identifier: Apache-2.0
// Puts the coordinates that a twin's images without noise have in the place of measured ones, where fits
// look.
#pragma once
#include <vector>

#include "measure/fit/fit_types.hpp"
#include "measure/points/points.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::measure {

/// Replaces the coordinates of `decodes` (cameras that points are made of) by those of the images
/// `noise_free` of the same cameras, with their sigmas left, in a box about the pixels of the fits and about
/// what the second camera sees of them; outside the boxes no coordinate is left. Only the boxes are decoded,
/// each camera's with its `options`. `cloud`, `fits`: of the measured coordinates. smoothing_px: what follows
/// smooths by so much.
void take_noise_free_coordinates(const Fringes& fringes, const std::vector<CameraImages>& noise_free,
                                 const std::vector<DecodeOptions>& options, const PointCloud& cloud,
                                 const std::vector<ObjectFit>& fits, double smoothing_px,
                                 std::vector<CameraDecode>& decodes);

}  // namespace fringetwin::measure
