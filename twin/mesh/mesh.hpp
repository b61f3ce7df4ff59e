// SPDX-License-Identifier: Apache-2.0
// A triangle mesh in memory, read from PLY, STL or OBJ.
#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <memory>
#include <vector>

namespace fringetwin {

struct Mesh {
  std::vector<Eigen::Vector3f> vertices_mm;
  std::vector<std::array<int, 3>> triangles;    ///< vertex indices
  std::vector<Eigen::Vector3f> vertex_normals;  ///< unit; empty = compute area-weighted on demand
  std::vector<float> vertex_albedo;             ///< optional factor on diffuse, per vertex (measured shapes)
};

/// Reads PLY, STL or OBJ; `unit` "mm" or "m". Vertices of equal position are joined, polygons cut
/// into triangles, degenerate (zero-area) triangles dropped and counted on stderr; normals and
/// colours in the file are ignored.
/// Throws UserError(input) naming the file for: missing, truncated or unknown format, no triangle or more
/// than kMostTriangles, a NaN or infinite coordinate (names the vertex); Cancelled where the user pressed
/// Ctrl-C.
std::shared_ptr<const Mesh> load_mesh(const std::filesystem::path& file, const std::string& unit);

/// Returns area-weighted unit vertex normals.
std::vector<Eigen::Vector3f> compute_vertex_normals(const Mesh& mesh);

}  // namespace fringetwin
