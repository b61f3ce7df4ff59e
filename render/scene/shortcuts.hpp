// SPDX-License-Identifier: Apache-2.0
// What the shaders need to find a camera ray's triangle from a neighbouring one and to leave out needless
// shadow rays (shaders/mesh.glsl): links between triangles, what hides none of them, where to start.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/scene/scene.hpp"
#include "render/scene/visibility.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Adjacency and visibility of meshes, kept for the eyes they were last asked for.
class VisibilityStore {
 public:
  const Adjacency& adjacency(const MeshGeometry& g);
  const std::vector<std::uint8_t>& clear(const MeshGeometry& g, const Eigen::Vector3d& eye_mm);

 private:
  struct Entry {
    std::weak_ptr<const Mesh> mesh;
    const MeshGeometry* geometry;
    Adjacency adjacency;
    std::vector<std::pair<Eigen::Vector3d, std::unique_ptr<std::vector<std::uint8_t>>>> views;
  };
  Entry& entry(const MeshGeometry& g);
  std::vector<std::unique_ptr<Entry>> entries_;
};

struct Shortcuts {
  int kinds = 0;                                   ///< LINKS_ bits, 0: none
  std::vector<std::array<std::int32_t, 4>> links;  ///< per instance and triangle, leaf order
  std::vector<std::int32_t> starts;                ///< per instance and tile
  std::uint32_t tile_shift = 0, tiles_x = 0, tiles = 0;
};

/// None where the scene has more than `most_triangles`: learning what hides them costs more than it saves.
Shortcuts make_shortcuts(const Twin& twin, const Camera& camera, const PackedScene& scene,
                         std::size_t most_triangles, VisibilityStore& store);

}  // namespace fringetwin::render
