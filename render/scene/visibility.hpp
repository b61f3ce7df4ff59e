// SPDX-License-Identifier: Apache-2.0
// Decides which triangles of a mesh no other triangle of it can hide from one point, the eye: rays from there
// that meet such a triangle need no search through the BVH. The decisions are exact in double precision and
// made once per place of the eye.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace fringetwin::render {

/// Tells which triangles share a side.
struct Adjacency {
  /// Per triangle and corner: the neighbour across the side opposite the corner, -1 where there is no single
  /// other triangle.
  std::vector<std::array<std::int32_t, 3>> neighbours;
  /// Every side has exactly one neighbour, wound the same way: a surface with an inside.
  bool closed = false;
};
/// Finds the neighbours of all triangles, given by the numbers of their vertices.
Adjacency make_adjacency(const std::vector<std::array<int, 3>>& triangles, std::size_t n_vertices);

/// Returns per triangle 1 where certainly no other triangle lies between `eye` and any point of it, else 0;
/// all 0 where the mesh is not wholly in front of the eye.
std::vector<std::uint8_t> clear_from(const Eigen::Vector3d& eye, const std::vector<Eigen::Vector3f>& vertices,
                                     const std::vector<std::array<int, 3>>& triangles);

}  // namespace fringetwin::render
