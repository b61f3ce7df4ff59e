// SPDX-License-Identifier: Apache-2.0
// A triangle mesh placed in the world: the file it comes from and where it stands.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/lens/pose.hpp"
#include "twin/mesh/mesh.hpp"
#include "twin/shape/motion.hpp"

namespace fringetwin {

struct MeshShape {
  static constexpr const char* kKind = "mesh";
  std::filesystem::path file;  ///< empty for a mesh made in memory
  std::string unit = "mm";
  Pose T_world_object;
  bool smooth = false;               ///< interpolated vertex normals instead of facets
  std::shared_ptr<const Mesh> mesh;  ///< filled by load_meshes(); the same pointer = an instance
};

/// Returns the shifts along the world's axes and the turns about them through the mean of its vertices, so
/// that turns and shifts stay apart.
std::vector<Motion<MeshShape>> motions(const MeshShape& shape);
std::vector<PlaceKey> place_keys(const MeshShape& shape);
inline void make_units(MeshShape&) {}
inline std::optional<Eigen::Vector3d> place_mm(const MeshShape& shape) {
  return shape.T_world_object.translation_mm;
}
inline bool shades_itself(const MeshShape&) { return true; }
inline std::vector<std::filesystem::path> shape_files(const MeshShape& shape) { return {shape.file}; }

}  // namespace fringetwin
