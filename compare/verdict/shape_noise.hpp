// SPDX-License-Identifier: Apache-2.0
// What the noise of a measured shape adds to the budgets of phase and gray values: neighbours share it, since
// each vertex is told by a window of pixels (docs/metrics/verdict.md, "Noise of a measured shape").
#pragma once
#include "measure/surface.hpp"

namespace fringetwin::compare {

/// The noise of the shapes that were built from this capture's own images.
struct ShapeNoise {
  measure::SurfaceNoise surface;
  /// Variance of a phase from the steps that the shape was built from over that from the steps that are
  /// compared.
  double of_phase = 1.0;
};

/// Variance of the mean over a square region over that of a single pixel: 1 where all share the error.
struct RegionShares {
  double depth = 1.0;  ///< of the value at the middle of a quadratic over each pixel's window
  double slope = 1.0;  ///< of its slopes
};

/// Returns what windows of this radius leave in the mean over a square of so many pixels a side, from white
/// noise.
RegionShares region_shares(double radius_px, int region_px);

}  // namespace fringetwin::compare
