// SPDX-License-Identifier: Apache-2.0
// Captures of a small rig as the double-precision reference sees them, with the noise of its sensor.
#pragma once
#include <functional>
#include <random>
#include <vector>

#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing {

/// Draws random numbers: normal ones, whose generator others may ask, too.
struct Draws {
  std::mt19937 random{7};
  std::normal_distribution<double> normal{0.0, 1.0};
};

/// What a pixel has of its own: DN = factor * gain * irradiance + offset.
struct PixelsOwn {
  double factor = 1.0, offset_dn = 0.0;
};

/// Returns the images of the rig's first camera, irradiance by Gauss's rule of `gauss_n` points a side,
/// rounded gray values with gain and read noise of its sensor (no shot noise, no clip) from a fixed seed.
/// `own`: called before the noise of each pixel is drawn.
std::vector<CameraImages> reference_captures(const Twin& rig, int gauss_n,
                                             const std::function<PixelsOwn(Draws&)>& own = {});

}  // namespace fringetwin::testing
