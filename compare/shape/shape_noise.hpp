// SPDX-License-Identifier: Apache-2.0
// What the noise of a measured shape adds to the budgets of phase and gray values: neighbours share it, since
// each vertex is told by a window of pixels (docs/metrics/verdict.md, "Explained").
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "compare/phase/phase_budget.hpp"
#include "measure/decode/decode_types.hpp"
#include "measure/surface_noise.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// The noise of the shapes that were built from this capture's own images.
struct ShapeNoise {
  measure::SurfaceNoise surface;
  /// Of the phase steps that are compared, the share that the shape was built from, too.
  double steps_in_shape = 0.0;
};

inline constexpr int kRegion = 16;  ///< px: side of a region of the verdict

/// Variance of the mean over a square region over that of a single pixel: 1 where all share the error.
struct RegionShares {
  double depth = 1.0;  ///< of the value at the middle of a quadratic over each pixel's window
  double slope = 1.0;  ///< of its slopes
};

/// Returns what windows of this radius leave in the mean over a square of so many pixels a side, from white
/// noise.
RegionShares region_shares(double radius_px, int region_px);

/// Returns the variance of a sum of depths weighted by a sine of this period, over that of as many whose
/// noise is their own: windows of this radius let neighbours share theirs.
double ripple_gain(double radius_px, double period_px);

inline constexpr double kRadiiPerPx = 10.0;  ///< how finely windows are told from each other

/// What smoothing has changed of a number at a pixel.
struct SmoothedAt {
  double size = 0.0;   ///< root of its mean square around the pixel, without noise
  double value = 0.0;  ///< its own with its sign, and noise
};

/// The noise of a measured shape in one camera's comparison; without one, nothing.
struct ShapeInView {
  const measure::SurfaceNoiseInView* noise = nullptr;
  /// By the radius of a pixel's window, kRadiiPerPx of them for each px: what a region's mean keeps, over
  /// what a pixel's does.
  std::vector<RegionShares> shares = {};
  double mean_radius_px = 0.0;
  double ambient = 0.0;  ///< irradiance of the room, which no normal shades
  const measure::CameraDecode* real =
      nullptr;  ///< whose amplitudes tell what moved fringes do to gray values
  /// Of the variance of a phase that the shape's noise makes, by how much of it the difference of both sides
  /// grows, along columns and rows: 1 where the shape has a noise of its own, 0 where it follows that of the
  /// compared steps, more where it goes against it.
  std::array<double, 2> moves{1.0, 1.0};
  bool shades = true;  ///< whether its normals' noise is seen: not where each pixel has a factor of its own
  /// What smoothing has changed of the shape, mean squares over each region, less what noise makes of them:
  /// of the shading, and px along columns and rows.
  ImageF smoothed_shading2 = {};
  std::array<ImageF, 2> smoothed_px2 = {};

  /// Returns what a mean over a region of the verdict keeps of this pixel's noise.
  const RegionShares& shares_at(std::size_t pixel) const { return shares[radius_at(pixel)]; }
  /// Returns the place of this pixel's window in `shares`.
  std::size_t radius_at(std::size_t pixel) const;
  /// Returns the relative standard error of the projector's light on a pixel.
  double shading_at(std::size_t pixel) const;
  /// Returns by how much smoothing has changed the projector's light on a pixel, relative, and the place that
  /// lights it, px along the projector's axis.
  SmoothedAt smoothed_shading_at(std::size_t pixel) const;
  SmoothedAt smoothed_px_at(Axis axis, std::size_t pixel) const;
  /// Returns by how much the noise of its depth, one standard error of it towards larger ones, moves what
  /// lights a pixel, px along the projector's axis, as both sides' difference sees it.
  double moved_px_at(Axis axis, std::size_t pixel) const;
};

inline constexpr const char* kSmoothedLine = "smoothing of the measured shape";

/// Returns what the noise of a shape (null: none) does in the comparison of this camera, of which the real
/// side's decode is given.
ShapeInView shape_in_view(const ShapeNoise* noise, const Twin& twin, std::size_t camera,
                          const measure::CameraDecode* real);

/// Counts what the shape's noise ripples with the fringes in a test's chi2, which then is 1 for noise again.
void count_shape(const ShapeInView& shape, const measure::DirectionDecode& real,
                 const measure::DirectionDecode& simulated, const ImageU8& interior, RippleTest& ripple);

}  // namespace fringetwin::compare
