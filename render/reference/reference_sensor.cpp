// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_sensor.hpp"

#include <algorithm>

namespace fringetwin::render {
namespace {

/// Returns the area below the slopes of a response from 0 to this input: its pieces added up one by one.
double area_below_slopes(const CameraResponse& response, double input_dn) {
  double area = 0.0, from_in = 0.0, from_out = 0.0;
  for (const CameraResponse::Corner& corner : response.corners) {
    const double slope = (corner.out_dn - from_out) / (corner.in_dn - from_in);
    area += slope * (std::clamp(input_dn, from_in, corner.in_dn) - from_in);
    from_in = corner.in_dn, from_out = corner.out_dn;
  }
  return area + response.last_slope * (std::max(input_dn, from_in) - from_in);
}

double at(const PixelMap& map, std::size_t pixel, double without) {
  return map.values ? static_cast<double>(map.values->data.at(pixel)) : without;
}

}  // namespace

double reference_mean_dn(const Sensor& sensor, double irradiance, std::size_t pixel) {
  const double electrons_as_dn = sensor.gain_dn * irradiance * at(sensor.prnu, pixel, 1.0);
  return area_below_slopes(sensor.response, electrons_as_dn) + sensor.black_level_dn +
         at(sensor.dsnu, pixel, 0.0);
}

}  // namespace fringetwin::render
