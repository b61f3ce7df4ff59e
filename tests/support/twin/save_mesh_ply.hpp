// SPDX-License-Identifier: Apache-2.0
// Writes a mesh as a file that load_mesh() and other programs read.
#pragma once
#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>

#include "twin/image/image_io.hpp"
#include "twin/mesh/mesh.hpp"

namespace fringetwin::testing {

/// Writes a binary little-endian PLY, mm, to a temporary name that is then renamed.
inline void save_mesh_ply(const std::filesystem::path& file, const Mesh& mesh) {
  static_assert(std::endian::native == std::endian::little);
  const bool normals = mesh.vertex_normals.size() == mesh.vertices_mm.size() && !mesh.vertices_mm.empty();
  const bool albedo = mesh.vertex_albedo.size() == mesh.vertices_mm.size() && !mesh.vertices_mm.empty();
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment fringetwin, unit mm\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n{}{}"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices_mm.size(), normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
      albedo ? "property float albedo\n" : "", mesh.triangles.size());
  out.reserve(out.size() + mesh.vertices_mm.size() * 28 + mesh.triangles.size() * 13);
  const auto append = [&](const void* data, std::size_t size) {
    out.append(static_cast<const char*>(data), size);
  };
  for (std::size_t i = 0; i < mesh.vertices_mm.size(); ++i) {
    append(mesh.vertices_mm[i].data(), 3 * sizeof(float));
    if (normals) append(mesh.vertex_normals[i].data(), 3 * sizeof(float));
    if (albedo) append(&mesh.vertex_albedo[i], sizeof(float));
  }
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    out.push_back(3);
    append(triangle.data(), 3 * sizeof(std::int32_t));
  }
  write_text_file(file, out);
}

}  // namespace fringetwin::testing
