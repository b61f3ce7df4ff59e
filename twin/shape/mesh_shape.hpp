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
  static constexpr bool kHasFiles = true, kLightsItself = true;
  std::filesystem::path file = {};  ///< empty for a mesh made in memory
  std::string unit = "mm";
  Pose T_world_object = {};
  bool smooth = false;                    ///< interpolated vertex normals instead of facets
  std::shared_ptr<const Mesh> mesh = {};  ///< filled by load_meshes(); the same pointer = an instance
};

/// Returns the shifts along the world's axes and the turns about them through the mean of its vertices, so
/// that turns and shifts stay apart.
inline std::vector<Motion<MeshShape>> motions(const MeshShape& shape) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  if (shape.mesh && !shape.mesh->vertices_mm.empty()) {
    for (const auto& p : shape.mesh->vertices_mm) middle += p.cast<double>();
    middle /= static_cast<double>(shape.mesh->vertices_mm.size());
  }
  const Eigen::Vector3d about = shape.T_world_object * middle;
  std::vector<Motion<MeshShape>> out;
  for (int i = 0; i < 3; ++i)
    out.push_back({std::string("shift_mm.") + "xyz"[i], "mm", 0.0,
                   [i](MeshShape& s, double d) { s.T_world_object.translation_mm[i] += d; }});
  for (int i = 0; i < 3; ++i)
    out.push_back({std::string("turn_rad.") + "xyz"[i], "rad", 0.0, [i, about](MeshShape& s, double d) {
                     s.T_world_object = turned(s.T_world_object, Eigen::Vector3d::Unit(i), d, about);
                   }});
  return out;
}

inline std::vector<PlaceKey> place_keys(const MeshShape& shape) {
  const RotTrans rt = rt_from_pose(shape.T_world_object);
  return {{"rt_world_object", {rt.begin(), rt.end()}}};
}

inline void make_units(MeshShape&) {}
inline std::optional<Eigen::Vector3d> place_mm(const MeshShape& shape) {
  return shape.T_world_object.translation_mm;
}
inline bool shades_itself(const MeshShape&) { return true; }
inline std::vector<std::filesystem::path> shape_files(const MeshShape& shape) { return {shape.file}; }
inline bool has_albedo(const MeshShape& shape) { return shape.mesh && !shape.mesh->vertex_albedo.empty(); }
inline void remove_albedo(MeshShape& shape) {
  auto plain = std::make_shared<Mesh>(*shape.mesh);
  plain->vertex_albedo.clear();
  shape.mesh = plain;
}

}  // namespace fringetwin
