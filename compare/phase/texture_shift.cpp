// SPDX-License-Identifier: Apache-2.0
#include "compare/phase/texture_shift.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

using measure::DirectionDecode;

constexpr double kClearSigmas = 3.0;  ///< of a difference between neighbours that is no noise

/// The logarithm of the real amplitude over the simulated one without its texture, and the variance that
/// noise gives it: that of the phase.
struct Weights {
  ImageF log, variance;
};

Weights weights_of(const DirectionDecode& real, const DirectionDecode& simulated,
                   const PixelTexture* texture) {
  const ImageF &a = real.amplitude_dn[real.finest], &b = simulated.amplitude_dn[simulated.finest];
  Weights out{ImageF(a.width, a.height), ImageF(a.width, a.height)};
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < a.size(); ++i) {
    const float r = real.sigma_rad.data[i], s = simulated.sigma_rad.data[i];
    out.variance.data[i] = r * r + s * s;
    // dark pixels tell nothing, and most images have many
    const auto factor = static_cast<float>(texture ? texture->factor_at(i) : 1.0);
    out.log.data[i] =
        std::isfinite(out.variance.data[i]) ? std::log(factor * a.data[i] / b.data[i]) : std::nanf("");
  }
  return out;
}

/// Returns the larger difference of ln w to the two neighbours at this distance in the image's data; 0 for
/// one that noise may make, or that is unknown.
double largest_step(const Weights& w, std::size_t i, std::size_t distance) {
  double largest = 0.0;
  for (const std::size_t k : std::array{i - distance, i + distance}) {
    const auto step = std::abs(static_cast<double>(w.log.data[k]) - static_cast<double>(w.log.data[i]));
    const auto noise = static_cast<double>(w.variance.data[k]) + static_cast<double>(w.variance.data[i]);
    if (std::isfinite(step) && step * step > kClearSigmas * kClearSigmas * noise)
      largest = std::max(largest, step);
  }
  return largest;
}

/// Returns half the difference of two values; 0 where it is unknown.
template <class T>
double central(const Image<T>& image, std::size_t i, std::size_t distance) {
  const double d =
      0.5 * (static_cast<double>(image.data[i + distance]) - static_cast<double>(image.data[i - distance]));
  return std::isfinite(d) ? d : 0.0;
}

}  // namespace

TextureShift texture_shift(const DirectionDecode& real, const DirectionDecode& simulated,
                           const PixelTexture* texture, double pixel_side_px) {
  const ImageD& x_px = simulated.coordinate_px;
  const Weights w = weights_of(real, simulated, texture);
  const double per_px = kTwoPi / real.pitches_px[real.finest];
  TextureShift out{ImageF(x_px.width, x_px.height, 0.0F), ImageF(x_px.width, x_px.height, 0.0F)};
  const auto row = static_cast<std::size_t>(x_px.width);
#pragma omp parallel for schedule(static)
  for (int y = 1; y < x_px.height - 1; ++y)
    for (int x = 1; x < x_px.width - 1; ++x) {
      const std::size_t i = x_px.index(x, y);
      if (!std::isfinite(w.log.data[i])) continue;
      double largest = 0.0, with_sign = 0.0;
      for (const std::size_t distance : {std::size_t{1}, row}) {
        const double step = largest_step(w, i, distance);
        if (step == 0.0) continue;
        const double slope = per_px * central(x_px, i, distance) / 12.0;
        largest += std::abs(slope) * step;
        with_sign += slope * central(w.log, i, distance);
      }
      // a smooth texture changes by the side's share within it, an edge may lie there whole
      out.largest_rad.data[i] = static_cast<float>(pixel_side_px * largest);
      out.signed_rad.data[i] = static_cast<float>(pixel_side_px * pixel_side_px * with_sign);
    }
  return out;
}

}  // namespace fringetwin::compare
