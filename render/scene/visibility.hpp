// SPDX-License-Identifier: Apache-2.0
// What a mesh hides of itself from one point: rays from there that meet a triangle nothing can hide need no
// search through the BVH. Exact decisions in double precision, made once per place of the eye.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace fringetwin::render {

/// Across the side opposite each corner, -1 where there is no single other triangle.
struct Adjacency {
  std::vector<std::array<std::int32_t, 3>> neighbours;
  /// Every side has exactly one neighbour, wound the same way: a surface with an inside.
  bool closed = false;
};
Adjacency make_adjacency(const std::vector<std::array<int, 3>>& triangles, std::size_t n_vertices);

/// Per triangle: can no other triangle lie between `eye` and any point of it? False where that is not
/// certain. All false where the mesh is not wholly in front of the eye.
std::vector<std::uint8_t> clear_from(const Eigen::Vector3d& eye, const std::vector<Eigen::Vector3f>& vertices,
                                     const std::vector<std::array<int, 3>>& triangles);

}  // namespace fringetwin::render
