// SPDX-License-Identifier: Apache-2.0
// Builds the mesh of an object with shape = "measured": the points that were measured on the real part go in,
// a smoothed triangle mesh that can be rendered comes out.
#pragma once
#include <cstddef>
#include <memory>

#include "measure/points/points.hpp"
#include "twin/image/image.hpp"
#include "twin/mesh/mesh.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// What the noise of the measured points leaves in a surface, over the vertices that the projector lights.
struct SurfaceNoise {
  double leverage = 1.0;   ///< mean variance of a vertex' inverse depth over the mean of its own pixel's
  double shading = 0.0;    ///< rms error of the light that pixels catch from the projector, over its rms
  double radius_px = 0.0;  ///< mean radius of the windows: neighbours within share their errors
  /// Of each pixel of the camera whose depths these are: leverage, times whose own variance is that of its
  /// vertex, and relative standard error of the projector's light; NaN where there is no vertex, or no light.
  ImageF leverage_of_pixel = {}, shading_of_pixel = {};
};

struct MeasuredSurface {
  std::shared_ptr<const Mesh> mesh;
  SurfaceNoise noise;
};

/// Returns the variance of a slope's mean over a pixel over that at a vertex, where fits to windows of this
/// radius tell the slopes of the vertices, and the surface goes evenly from one to the next.
double slope_share_in_pixel(double radius_px);

/// Returns the measured depth map of a camera as a mesh in the world frame, mm: smoothed locally as `shape`
/// says, with triangles between neighbouring pixels without a depth jump, and the normals of the local fits.
/// Throws UserError(input) when the cloud does not make a surface.
MeasuredSurface build_surface(const Twin& twin, std::size_t camera, const PointCloud& cloud,
                              const MeasuredShape& shape);

}  // namespace fringetwin::measure
