// SPDX-License-Identifier: Apache-2.0
// Builds a two-wide bounding volume hierarchy over a mesh's triangles by the binned surface area heuristic
// (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007), laid out for
// shaders/mesh.glsl.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "twin/mesh/mesh.hpp"

namespace fringetwin::render {

/// A node with both children's boxes; a child >= 0 is a node, a child < 0 a leaf: ~child = first * 8 + count
/// - 1.
struct BvhNode {
  Eigen::Vector3f left_min;
  std::int32_t left;
  Eigen::Vector3f left_max;
  std::int32_t unused0;
  Eigen::Vector3f right_min;
  std::int32_t right;
  Eigen::Vector3f right_max;
  std::int32_t unused1;
};
static_assert(sizeof(BvhNode) == 64);

struct Bvh {
  std::vector<BvhNode> nodes = {};        ///< [0] is the root
  std::vector<std::uint32_t> order = {};  ///< triangle of the mesh at each leaf slot
  int depth = 0;                          ///< longest path from the root to a leaf's parent, in nodes
  Eigen::Vector3f box_min = Eigen::Vector3f::Zero(), box_max = Eigen::Vector3f::Zero();
};

/// Builds the hierarchy, never deeper than max_depth (a traversal stack of that size suffices), with at most
/// 4 triangles in a leaf. The result does not depend on the number of threads.
Bvh build_bvh(const std::vector<Eigen::Vector3f>& vertices_mm,
              const std::vector<std::array<int, 3>>& triangles, int max_depth);

}  // namespace fringetwin::render
