// SPDX-License-Identifier: Apache-2.0
// Reads a decoded coordinate map (NaN = invalid) between its pixels, with its gradient.
#pragma once
#include "measure/decode/decode.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::measure {

struct MapSample {
  double value = 0.0, d_dx = 0.0, d_dy = 0.0;
  double error_px = 0.0;  ///< size of the interpolation error, from the first neglected differences
  /// Standard deviation of the value over that of a pixel: square root of the sum of the squared weights, 1
  /// at a pixel and 0.64 in the middle of four.
  double noise_gain = 1.0;
};

/// Interpolates with 4x4 Lagrange cubics; the stencil is centred on the pixel cell where all 16
/// pixels are valid and belong to one smooth piece, else shifted by one pixel towards valid ground,
/// else bilinear on the 2x2 cell. Nothing is read across a jump: within a stencil the third
/// differences must stay below kSlopeFraction of the local slope (plus noise), which a smooth
/// surface does and a depth jump does not.
class CoordinateMap {
 public:
  /// Keeps references: `map` and `sigma` must outlive this. `sigma` may be empty (no noise known).
  /// `smoothed`: neighbours share their noise, which the interpolation then does not lessen.
  CoordinateMap(const ImageD& map, const ImageF& sigma, bool smoothed = false);
  bool sample(double x, double y, MapSample& out) const;
  /// Returns the mean of noise_gain^2 over all places between pixels that are not smoothed.
  static double mean_noise_gain_sq();
  /// Returns the noise of the nearest pixel, 0 where unknown.
  double sigma_px(double x, double y) const;
  double typical_sigma_px() const { return typical_sigma_px_; }
  const ImageD& image() const { return map_; }

 private:
  bool sample_cubic(int x0, int y0, double x, double y, double noise_px, MapSample& out) const;
  bool sample_linear(int x0, int y0, double x, double y, double noise_px, MapSample& out) const;
  double difference_noise_px(int x, int y) const;

  static constexpr double kSlopeFraction = 0.3;
  const ImageD& map_;
  const ImageF& sigma_;
  bool smoothed_ = false;
  double typical_sigma_px_ = 0.0;  ///< median over valid pixels
};

}  // namespace fringetwin::measure
