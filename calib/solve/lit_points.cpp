// SPDX-License-Identifier: Apache-2.0
#include "calib/solve/lit_points.hpp"

#include <cmath>
#include <limits>

namespace fringetwin::calib {

std::vector<LitPoint> lit_points(const measure::Measurement& measurement, std::size_t most) {
  const measure::CameraDecode& decode = measurement.cameras.front();
  const measure::DirectionDecode* columns = decode.direction(Axis::x);
  const measure::DirectionDecode* rows = decode.direction(Axis::y);
  std::vector<LitPoint> out;
  if (!columns) return out;
  const std::size_t n = measurement.cloud.size();
  const int stride =
      static_cast<int>(std::ceil(std::sqrt(static_cast<double>(n) / static_cast<double>(most))));
  const int tiles_across = decode.width() / kTilePx + 1;
  for (std::size_t i = 0; i < n; ++i) {
    const long x = std::lround(measurement.cloud.q_cam_px[i].x()),
               y = std::lround(measurement.cloud.q_cam_px[i].y());
    if (x % stride != 0 || y % stride != 0) continue;
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    LitPoint point{
        .p_world_mm = measurement.cloud.p_world_mm[i],
        .q_projector_px = {columns->coordinate_px(ix, iy), std::numeric_limits<double>::quiet_NaN()},
        .sigma_px = {columns->coordinate_sigma_px(ix, iy), 1.0},
        .depth_sigma_mm = measurement.cloud.sigma_mm[i],
        .tile = iy / kTilePx * tiles_across + ix / kTilePx};
    if (rows) {
      point.q_projector_px.y() = rows->coordinate_px(ix, iy);
      point.sigma_px.y() = rows->coordinate_sigma_px(ix, iy);
      if (!std::isfinite(point.q_projector_px.y()) || !(point.sigma_px.y() > 0.0)) continue;
    }
    if (!std::isfinite(point.q_projector_px.x()) || !(point.sigma_px.x() > 0.0)) continue;
    out.push_back(point);
  }
  return out;
}

}  // namespace fringetwin::calib
