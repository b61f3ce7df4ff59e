// SPDX-License-Identifier: Apache-2.0
// Takes out of phase steps what the twin already knows to be in them besides plain fringes, so that a shape
// that is measured from them holds none of it (docs/metrics/measure.md, "Plain fringes").
#pragma once
#include <Eigen/Core>
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// Returns whether the twin knows of anything: harmonics, also of places and single images, waves of the
/// raster, shifts or light of single images, exposures; of sinusoidal fringes behind linear responses, whose
/// blur is the same everywhere, under a steady light of the room, each image of one pattern.
bool knows_light(const Twin& twin, const Camera& camera);

/// Returns the images of a camera without that. `places_px`: of each pixel the place in the projector's image
/// that lights it, good enough to tell the fringe's order; where it is NaN waves of the raster and what
/// harmonics have more there stay. Of every pixel its own fringe is fitted to `steps` alone, all where it is
/// empty, and only these are changed; the noise stays. Pixels with a clipped value are left alone; clipped
/// values go up with Clip::dn, so that no other value seems to be one.
CameraImages without_known_light(CameraImages images, const Twin& twin, const Camera& camera,
                                 const std::vector<Eigen::Vector2f>& places_px, std::vector<int> steps = {});

}  // namespace fringetwin::cosim
