// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/interior_mask.hpp"

#include <algorithm>
#include <cmath>

namespace fringetwin::compare {
namespace {

using measure::CameraDecode;
using measure::DirectionDecode;

constexpr double kKink_px = 1.0;      ///< projector px
constexpr double kKinkSigmas = 12.0;  ///< of one coordinate: sqrt(6) times 5

ImageU8 eroded(const ImageU8& mask) {
  ImageU8 out(mask.width, mask.height, 0);
#pragma omp parallel for schedule(static)
  for (int y = 1; y < mask.height - 1; ++y)
    for (int x = 1; x < mask.width - 1; ++x) {
      bool all = true;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) all = all && mask(x + dx, y + dy) != 0;
      out(x, y) = all ? 1 : 0;
    }
  return out;
}

/// Clears pixels where the coordinate has a kink or a jump. NaN (not unwrapped) compares as smooth.
void clear_kinks(const DirectionDecode& d, ImageU8& mask) {
  if (d.coordinate_px.empty()) return;
  const ImageD& at = d.coordinate_px;
#pragma omp parallel for schedule(static)
  for (int y = 1; y < mask.height - 1; ++y)
    for (int x = 1; x < mask.width - 1; ++x) {
      if (mask(x, y) == 0) continue;
      const auto sigma =
          d.coordinate_sigma_px.empty() ? 0.0 : static_cast<double>(d.coordinate_sigma_px(x, y));
      const double most = std::max(kKink_px, kKinkSigmas * (std::isfinite(sigma) ? sigma : 0.0));
      const double across = std::abs(at(x + 1, y) - 2.0 * at(x, y) + at(x - 1, y));
      const double down = std::abs(at(x, y + 1) - 2.0 * at(x, y) + at(x, y - 1));
      if (across > most || down > most) mask(x, y) = 0;
    }
}

}  // namespace

ImageU8 interior_mask(const ImageU8& mask, const CameraDecode* real, const CameraDecode* simulated) {
  ImageU8 inside = eroded(mask);
  for (const CameraDecode* side : {real, simulated})
    if (side)
      for (const DirectionDecode& d : side->directions) clear_kinks(d, inside);
  return eroded(inside);
}

}  // namespace fringetwin::compare
