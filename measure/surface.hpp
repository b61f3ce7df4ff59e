// SPDX-License-Identifier: Apache-2.0
// Builds the mesh of an object with shape = "measured": the points that were measured on the real part go in,
// a smoothed triangle mesh that can be rendered comes out.
#pragma once
#include <cstddef>
#include <memory>

#include "measure/points/points.hpp"
#include "measure/surface_noise.hpp"
#include "twin/mesh/mesh.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

struct MeasuredSurface {
  std::shared_ptr<const Mesh> mesh;
  SurfaceNoise noise;
};

/// Variance of a mean over a pixel over that at a vertex.
struct PixelShares {
  double depth = 1.0, slope = 1.0;
};
/// Returns the shares where fits of quadratics to windows of this radius tell the vertices, and the surface
/// goes evenly from one to the next.
PixelShares shares_in_pixel(double radius_px);

/// Returns the measured depth map of a camera as a mesh in the world frame, mm: smoothed locally as `shape`
/// says, with triangles between neighbouring pixels without a depth jump, and the normals of the local fits.
/// Throws UserError(input) when the cloud does not make a surface.
MeasuredSurface build_surface(const Twin& twin, std::size_t camera, const PointCloud& cloud,
                              const MeasuredShape& shape);

}  // namespace fringetwin::measure
