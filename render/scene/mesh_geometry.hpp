// SPDX-License-Identifier: Apache-2.0
// A mesh of the twin becomes what the shaders trace: a bounding volume hierarchy and triangles in its leaves'
// order, in coordinates so small that single precision suffices.
#pragma once
#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "render/scene/bvh.hpp"
#include "render/shaders/shared.h"
#include "twin/mesh/mesh.hpp"

namespace fringetwin::render {

/// A mesh ready for tracing: BVH and triangles in leaf order, relative to `center_mm` (object frame).
struct MeshGeometry {
  std::shared_ptr<const Mesh> mesh;
  Eigen::Vector3d center_mm;
  Bvh bvh;
  std::vector<gpu::vec4> triangles;         ///< 3 vertices each; w: the unit normal's x, y, z
  std::vector<gpu::vec4> corners;           ///< 3 x (normal, albedo) each
  std::vector<Eigen::Vector3f> vertices;    ///< relative to center_mm
  std::vector<std::array<int, 3>> indices;  ///< of the triangles' vertices, in leaf order
  std::vector<Eigen::Vector4f> covering;    ///< a few spheres (centre, radius) that cover it, for culling
};

/// Builds the geometry of a mesh, without the triangles that have no area. Throws UserError(input), naming
/// `name`, when none is left or a coordinate is not finite.
MeshGeometry build_mesh_geometry(std::shared_ptr<const Mesh> mesh, const std::string& name);

/// Returns the generalised winding number of the mesh's surface around a point (object frame): 1 inside a
/// closed mesh, 0 outside, in between for an open one. Van Oosterom and Strackee's solid angles.
double winding_number(const Mesh& mesh, const Eigen::Vector3d& point_mm);

/// Keeps the geometries of meshes, so that each is built once.
class MeshStore {
 public:
  /// Finds the geometry of a mesh or builds it; `name` stands in error messages. The reference stays valid as
  /// long as anybody else holds the mesh.
  const MeshGeometry& get(const std::shared_ptr<const Mesh>& mesh, const std::string& name);

 private:
  std::vector<std::unique_ptr<MeshGeometry>> meshes_;
};

}  // namespace fringetwin::render
