// SPDX-License-Identifier: Apache-2.0
// Measures the error of rendered images at the pixels of a subset: the double-precision reference renderer
// gives their true values, the rendered images their values, and the rms difference comes out.
#pragma once
#include <vector>

#include "tradeoff/image_change.hpp"
#include "tradeoff/pixel_subset.hpp"

namespace fringetwin::tradeoff {

/// States how finely the reference samples a pixel: Gauss-Legendre points along each side.
struct ReferenceOptions {
  int gauss_interior = 16;  ///< interior pixels, as docs/CONVENTIONS.md defines them
  int gauss_facet = 32;     ///< neither interior nor edge: edges between facets of a mesh
  int gauss_edge = 64;      ///< silhouettes and borders of light
};

/// Holds what the subset's pixels truly show: gray values before the sensor (gain E + black, no rounding).
struct ReferenceValues {
  std::vector<PixelValues> dn;              ///< [camera]
  std::vector<std::vector<bool>> interior;  ///< [camera][pixel], docs/CONVENTIONS.md
  /// Uncertainty of these values themselves at edges, DN: rms change on every eighth edge pixel when it is
  /// sampled by 3/4 of the points per side. NaN without edge pixels.
  double edge_uncertainty_dn = 0.0;
};
/// Returns the values that the double-precision reference renderer computes. Throws Cancelled. With depth of
/// field the edges get fewer samples (gauss_facet), 48 lens points each.
ReferenceValues reference_values(const Twin& twin, const PixelSubset& subset,
                                 const ReferenceOptions& options = {});

/// Returns the error of rendered images, given as values at the subset's pixels; the reference says which
/// pixels are interior.
ImageChange error_against(const ReferenceValues& reference, const Twin& twin, const PixelSubset& subset,
                          const std::vector<PixelValues>& rendered_dn);

/// Returns the rendered values before the sensor, DN, at the subset's pixels: [camera]. Takes whole images.
std::vector<PixelValues> dn_from_images(const Twin& twin, const PixelSubset& subset,
                                        const std::vector<render::RenderedCamera>& whole);
/// Returns the same from renderings of the windows of window_twin().
std::vector<PixelValues> dn_from_windows(const Twin& twin, const PixelSubset& subset,
                                         const std::vector<render::RenderedCamera>& windows);

}  // namespace fringetwin::tradeoff
