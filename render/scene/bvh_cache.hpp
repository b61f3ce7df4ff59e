// SPDX-License-Identifier: Apache-2.0
// Keeps the bounding volume hierarchies of large meshes on disk, by the content of the mesh.
#pragma once
#include "render/base/disk_cache.hpp"
#include "render/scene/bvh.hpp"

namespace fringetwin::render {

/// From here on reading a hierarchy is clearly quicker than building it (bench_scaling).
constexpr std::size_t kSmallestCachedMesh = 200'000;

/// Returns build_bvh() of the triangles. From `smallest` triangles on it is read from `folder` if an equal
/// mesh was built before, else built and kept there.
Bvh cached_bvh(const std::vector<Eigen::Vector3f>& vertices_mm,
               const std::vector<std::array<int, 3>>& triangles, int max_depth,
               const std::optional<std::filesystem::path>& folder,
               std::size_t smallest = kSmallestCachedMesh);

}  // namespace fringetwin::render
