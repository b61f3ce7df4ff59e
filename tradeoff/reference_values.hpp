// SPDX-License-Identifier: Apache-2.0
// The double-precision reference over a subset's pixels, and errors against it.
#pragma once
#include <vector>

#include "tradeoff/image_change.hpp"
#include "tradeoff/pixel_subset.hpp"

namespace fringetwin::study {

struct TruthOptions {
  int gauss_interior = 16;  ///< samples per side of a pixel, interior as docs/CONVENTIONS.md defines it
  int gauss_facet = 32;     ///< not interior, but no silhouette or border of light: facet edges
  int gauss_edge = 64;      ///< silhouettes and borders of light
};

/// Gray values before the sensor (gain E + black, no rounding) of the subset's pixels.
struct Truth {
  std::vector<PixelValues> dn;              ///< [camera]
  std::vector<std::vector<bool>> interior;  ///< [camera][pixel], docs/CONVENTIONS.md
  /// How well the truth itself is known: rms difference on every eighth edge pixel to 3/4 of the samples
  /// per side, DN; NaN without edge pixels.
  double edge_uncertainty_dn = 0.0;
};
/// Throws Cancelled. With depth of field the edges get fewer samples (gauss_facet), 48 lens points each.
Truth make_truth(const Twin& twin, const PixelSubset& subset, const TruthOptions& options = {});

/// Error of rendered images over the subset; interior as the truth has it.
ImageChange error_against(const Truth& truth, const Twin& twin, const PixelSubset& subset,
                          const std::vector<PixelValues>& rendered_dn);

/// Values before the sensor at the subset's pixels, from whole images or from the windows of
/// window_twin().
std::vector<PixelValues> subset_values(const Twin& twin, const PixelSubset& subset,
                                       const std::vector<render::RenderedCamera>& whole);
std::vector<PixelValues> window_values(const Twin& twin, const PixelSubset& subset,
                                       const std::vector<render::RenderedCamera>& windows);

}  // namespace fringetwin::study
