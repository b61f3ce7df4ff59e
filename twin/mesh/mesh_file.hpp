// SPDX-License-Identifier: Apache-2.0
// Reads what a mesh file holds, before mesh.cpp scales, joins and cleans it.
#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace fringetwin {

struct RawMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< in the file's unit; NaN and infinity not yet refused
  std::vector<float> albedo;              ///< one per vertex, or empty
  std::vector<std::array<int, 3>> triangles;
  std::size_t other_faces = 0;                          ///< points and lines, left out
  std::function<std::string(std::size_t)> vertex_name;  ///< how the file counts its vertices
};

/// Reads ASCII and binary PLY of either byte order. Polygons become fans. Ignores normals, colours, other
/// properties and elements. Throws UserError(input). Own code: assimp 5.2 reads beyond the end of a
/// truncated binary PLY and keeps indices of vertices that do not exist.
RawMesh read_ply(const std::filesystem::path& file, const std::string& bytes);

/// Reads STL (ASCII or binary) or OBJ through assimp; `format` "stl" or "obj".
RawMesh read_with_assimp(const std::filesystem::path& file, const std::string& bytes,
                         const std::string& format);

}  // namespace fringetwin
