// SPDX-License-Identifier: Apache-2.0
// What a pixel of a sensor makes of its light, once more in double precision and by another formula.
#pragma once
#include <cstddef>

#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns the mean gray value, before noise, rounding and clipping, of a pixel that gets this irradiance:
/// gain, factor of the pixel, response, black level, offset of the pixel.
double reference_mean_dn(const Sensor& sensor, double irradiance, std::size_t pixel);

}  // namespace fringetwin::render
