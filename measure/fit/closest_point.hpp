// SPDX-License-Identifier: Apache-2.0
// Finds the exact closest point on a triangle mesh, in double, with a bounding volume hierarchy.
#pragma once
#include <Eigen/Core>
#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "twin/mesh/mesh.hpp"

namespace fringetwin::measure {

struct ClosestPoint {
  int triangle = -1;  ///< -1: nothing within the search distance
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit normal of that triangle
  /// Positive on the side the normals point to. The side is told by the angle-weighted
  /// pseudo-normal of the closest vertex, edge or face (Baerentzen & Aanaes 2005).
  double signed_distance_mm = std::numeric_limits<double>::quiet_NaN();
};

/// Immutable after construction: query() may be called from many threads.
class MeshDistance {
 public:
  /// Throws UserError(input) for a mesh without triangles.
  explicit MeshDistance(const Mesh& mesh);
  /// Returns the surface point nearest to p_mm, both in the mesh's own frame.
  ClosestPoint query(const Eigen::Vector3d& p_mm,
                     double max_distance_mm = std::numeric_limits<double>::infinity()) const;

 private:
  struct Node {
    Eigen::Vector3d low, high;
    int first = 0;  ///< leaf: first triangle; inner: the right child (the left one follows)
    int count = 0;  ///< triangles in a leaf; 0 = inner node
  };
  struct Triangle {
    Eigen::Vector3d a, b, c, normal;
    std::array<int, 3> vertex{};
    std::array<Eigen::Vector3f, 3> edge_normal;  ///< of ab, bc, ca
    int index = 0;                               ///< in the mesh
  };
  void build(std::vector<int>& order, std::vector<Triangle>& triangles, int first, int count);
  void set_pseudo_normals();

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;  ///< leaf order
  std::vector<Eigen::Vector3d> vertex_normal_;
};

/// Returns the one tree of a mesh, shared while anybody holds it. Thread safe.
std::shared_ptr<const MeshDistance> mesh_distance_for(const std::shared_ptr<const Mesh>& mesh);

}  // namespace fringetwin::measure
