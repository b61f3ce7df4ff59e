// SPDX-License-Identifier: Apache-2.0
// Puts the coordinates that a twin's images without noise have in the place of measured ones, where fits
// look.
#pragma once
#include <vector>

#include "measure/fit/fit_types.hpp"
#include "measure/points/points.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// Replaces the coordinates of `decodes` (cameras that points are made of, order of twin.cameras) by those of
/// the images `noise_free`, with their sigmas left, in a box about the pixels of the fits and about what the
/// second camera sees of them; outside the boxes no coordinate is left. Only the boxes are decoded.
/// `cloud`, `fits`: of the measured coordinates. smoothing_px: what follows smooths by so much.
void take_noise_free_coordinates(const Twin& twin, const std::vector<CameraImages>& noise_free,
                                 const PointCloud& cloud, const std::vector<ObjectFit>& fits,
                                 const std::vector<int>& use_steps, double smoothing_px,
                                 std::vector<CameraDecode>& decodes);

}  // namespace fringetwin::measure
