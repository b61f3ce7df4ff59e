// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/mixed_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fringetwin::measure {
namespace {

constexpr int kDirections[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}};

/// Returns whether the pixel is displaced by more than its noise.
bool is_mixed(const DirectionDecode& d, int x, int y) {
  const ImageD& c = d.coordinate_px;
  const ImageF& amplitude = d.amplitude_dn[d.finest];
  const auto inside = [&](int i, int j) { return i >= 0 && j >= 0 && i < c.width && j < c.height; };
  const auto sigma = static_cast<double>(d.coordinate_sigma_px(x, y));
  for (const auto& [dx, dy] : kDirections) {
    if (!inside(x - dx, y - dy) || !inside(x + 2 * dx, y + 2 * dy)) continue;
    if (std::isfinite(c(x - dx, y - dy))) continue;
    const double slope = std::abs(c(x + dx, y + dy) - c(x + 2 * dx, y + 2 * dy));
    if (!std::isfinite(slope)) continue;
    const double shift_px = centroid_shift_px(static_cast<double>(amplitude(x, y)),
                                              static_cast<double>(amplitude(x + dx, y + dy)),
                                              static_cast<double>(amplitude(x + 2 * dx, y + 2 * dy)));
    if (shift_px * slope > sigma) return true;
  }
  return false;
}

DirectionDecode coordinates_only(const DirectionDecode& d) {
  DirectionDecode out;
  out.axis = d.axis;
  out.unwrapped = d.unwrapped;
  out.pitches_px = d.pitches_px;
  out.finest = d.finest;
  out.coordinate_px = d.coordinate_px;
  out.coordinate_sigma_px = d.coordinate_sigma_px;
  return out;
}

}  // namespace

double centroid_shift_px(double a0, double a1, double a2) {
  constexpr double kMost = 0.5;
  if (!(a0 > 0.0)) return kMost;
  const double full = 2.0 * a1 - a2;
  const double partly_filled = full > a0 ? 0.5 * (1.0 - a0 / full) : 0.0;
  const double falling = std::max(0.0, a1 - a0) / (12.0 * a0);
  return std::min(kMost, std::max(partly_filled, falling));
}

CameraDecode without_mixed_pixels(const CameraDecode& decode, std::size_t& n_left_out) {
  CameraDecode out;
  out.camera = decode.camera;
  out.flags = decode.flags;
  for (const DirectionDecode& d : decode.directions) out.directions.push_back(coordinates_only(d));
  std::size_t count = 0;
#pragma omp parallel for schedule(static) reduction(+ : count)
  for (int y = 0; y < decode.height(); ++y)
    for (int x = 0; x < decode.width(); ++x) {
      bool mixed = false;
      for (const DirectionDecode& d : decode.directions)
        // a code without phases names whole words: nothing to displace
        mixed =
            mixed || (!d.wrapped_rad.empty() && std::isfinite(d.coordinate_px(x, y)) && is_mixed(d, x, y));
      if (!mixed) continue;
      ++count;
      for (DirectionDecode& d : out.directions) {
        d.coordinate_px(x, y) = std::numeric_limits<double>::quiet_NaN();
        d.coordinate_sigma_px(x, y) = std::numeric_limits<float>::quiet_NaN();
      }
    }
  n_left_out += count;
  return out;
}

}  // namespace fringetwin::measure
