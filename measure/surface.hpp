// SPDX-License-Identifier: Apache-2.0
// Builds the mesh of an object with shape = "measured": the points that were measured on the real part go in,
// a smoothed triangle mesh that can be rendered comes out.
#pragma once
#include <cstddef>
#include <memory>

#include "measure/points/points.hpp"
#include "twin/mesh/mesh.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure {

/// Returns the measured depth map of a camera as a mesh in the world frame, mm: smoothed locally over
/// smoothing_px, with triangles between neighbouring pixels without a depth jump. Throws UserError(input)
/// when the cloud does not make a surface.
std::shared_ptr<const Mesh> build_surface(const Twin& twin, std::size_t camera, const PointCloud& cloud,
                                          double smoothing_px);

/// Returns the variance of a smoothed inverse depth over that of a single one, where the whole window is
/// measured: 1 without smoothing.
double smoothing_leverage(double smoothing_px);

}  // namespace fringetwin::measure
