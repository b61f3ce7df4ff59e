// SPDX-License-Identifier: Apache-2.0
// Makes the tables by which the shaders find a camera ray's triangle from a neighbouring one and leave out
// needless shadow rays (shaders/mesh.glsl): links between triangles, marks of those that nothing hides, and a
// triangle to start from for each tile of pixels.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/scene/scene.hpp"
#include "render/scene/visibility.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Keeps the adjacency of meshes and their visibility from the eyes that were last asked for.
class VisibilityStore {
 public:
  /// Returns the adjacency of a mesh's triangles, made at the first call.
  const Adjacency& adjacency(const MeshGeometry& g);
  /// Returns clear_from() the eye (geometry's frame) for the mesh's triangles.
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

/// Makes the shortcuts for the rays of one camera and the projector; none where the scene has more than
/// `most_triangles`, since learning what hides them then costs more than it saves.
Shortcuts make_shortcuts(const Twin& twin, const Camera& camera, const PackedScene& scene,
                         std::size_t most_triangles, VisibilityStore& store);

}  // namespace fringetwin::render
