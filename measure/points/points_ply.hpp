// SPDX-License-Identifier: Apache-2.0
// Writes triangulated points as a PLY file (docs/formats/results.md, "What measure writes").
#pragma once
#include <cstddef>
#include <filesystem>
#include <vector>

#include "measure/points/ply_vertices.hpp"
#include "measure/points/points.hpp"

namespace fringetwin::measure {

/// Returns x y z (double, mm, world frame), nx ny nz and scalar_sigma_mm (float, NaN where unknown) of these
/// points of a cloud. Both must outlive what is returned.
PlyVertices ply_of_points(const PointCloud& cloud, const std::vector<std::size_t>& index);
/// The same of all its points.
PlyVertices ply_of_points(const PointCloud& cloud);

/// Writes all points, first under a temporary name: besides what ply_of_points() gives, their source pixel
/// and, of `first_camera` (may be null), what was decoded there: the channels of its phase_<camera>.exr
/// without the wrapped phases.
void write_points_ply(const std::filesystem::path& file, const PointCloud& cloud,
                      const CameraDecode* first_camera);

}  // namespace fringetwin::measure
