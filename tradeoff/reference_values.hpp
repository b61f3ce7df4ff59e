// SPDX-License-Identifier: Apache-2.0
// Takes the double-precision reference at the pixels of a subset, and says how far rendered images are off
// it.
#pragma once
#include <vector>

#include "tradeoff/image_change.hpp"
#include "tradeoff/pixel_subset.hpp"

namespace fringetwin::tradeoff {

struct ReferenceOptions {
  int gauss_interior = 16;  ///< samples per side of a pixel, interior as docs/CONVENTIONS.md defines it
  int gauss_facet = 32;     ///< not interior, but no silhouette or border of light: facet edges
  int gauss_edge = 64;      ///< silhouettes and borders of light
};

/// What the subset's pixels truly show: gray values before the sensor (gain E + black, no rounding).
struct ReferenceValues {
  std::vector<PixelValues> dn;              ///< [camera]
  std::vector<std::vector<bool>> interior;  ///< [camera][pixel], docs/CONVENTIONS.md
  /// How well they are known themselves: rms difference on every eighth edge pixel to 3/4 of the samples
  /// per side, DN; NaN without edge pixels.
  double edge_uncertainty_dn = 0.0;
};
/// Samples the scene by the double-precision reference. Throws Cancelled. With depth of field the edges get
/// fewer samples (gauss_facet), 48 lens points each.
ReferenceValues reference_values(const Twin& twin, const PixelSubset& subset,
                                 const ReferenceOptions& options = {});

/// Returns the error of rendered images over the subset; interior as the reference has it.
ImageChange error_against(const ReferenceValues& reference, const Twin& twin, const PixelSubset& subset,
                          const std::vector<PixelValues>& rendered_dn);

/// Return the values before the sensor at the subset's pixels, from whole images or from the windows of
/// window_twin().
std::vector<PixelValues> subset_values(const Twin& twin, const PixelSubset& subset,
                                       const std::vector<render::RenderedCamera>& whole);
std::vector<PixelValues> window_values(const Twin& twin, const PixelSubset& subset,
                                       const std::vector<render::RenderedCamera>& windows);

}  // namespace fringetwin::tradeoff
