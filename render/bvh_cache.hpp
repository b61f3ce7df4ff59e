// SPDX-License-Identifier: Apache-2.0
// Hierarchies of large meshes, kept on disk by the content of the mesh.
#pragma once
#include <filesystem>
#include <optional>

#include "render/bvh.hpp"

namespace fringetwin::render {

/// FRINGETWIN_CACHE; without it fringetwin/ in XDG_CACHE_HOME or ~/.cache. None if FRINGETWIN_CACHE is empty
/// or there is no home.
std::optional<std::filesystem::path> cache_folder();

/// From here on reading a hierarchy is clearly quicker than building it (bench_scaling).
constexpr std::size_t smallest_cached_mesh = 200'000;
/// The oldest files make room.
constexpr std::uintmax_t largest_cache_bytes = std::uintmax_t{2} << 30;

/// As build_bvh. From smallest_cached_mesh triangles on it is read from `folder` if an equal mesh was built
/// before, else built and written there. A damaged file is replaced; a folder that cannot be written costs
/// nothing but time.
Bvh cached_bvh(const std::vector<Eigen::Vector3f>& vertices_mm,
               const std::vector<std::array<int, 3>>& triangles, int max_depth,
               const std::optional<std::filesystem::path>& folder);

}  // namespace fringetwin::render
