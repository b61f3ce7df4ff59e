// SPDX-License-Identifier: Apache-2.0
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <cstdint>
#include <cstring>

#include "twin/base/errors.hpp"
#include "twin/mesh/mesh_file.hpp"

namespace fringetwin {
namespace {

/// assimp accepts an ASCII STL that stops between two facets.
void check_stl_end(const std::filesystem::path& file, const std::string& bytes) {
  std::uint32_t facets = 0;
  if (bytes.size() >= 84) std::memcpy(&facets, bytes.data() + 80, 4);  // little-endian, as amd64 is
  const bool ascii =
      bytes.rfind("solid", 0) == 0 && bytes.size() != 84 + 50 * static_cast<std::size_t>(facets);
  if (ascii && bytes.rfind("endsolid") == std::string::npos)
    throw UserError(ExitCode::input, file.string(), "is truncated (an ASCII STL without endsolid)");
  if (!ascii && bytes.size() < 84 + 50 * static_cast<std::size_t>(facets))
    throw UserError(ExitCode::input, file.string(),
                    fmt::format("is truncated (a binary STL of {} facets has {} bytes, this file {})", facets,
                                84 + 50 * static_cast<std::size_t>(facets), bytes.size()));
}

void append(const aiMesh& part, RawMesh* mesh) {
  const int base = static_cast<int>(mesh->vertices.size());
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D& v = part.mVertices[i];
    mesh->vertices.emplace_back(v.x, v.y, v.z);
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) {
      ++mesh->other_faces;
      continue;
    }
    std::array<int, 3> triangle{};
    for (unsigned k = 0; k < 3; ++k) {
      FT_CHECK(face.mIndices[k] < part.mNumVertices, "assimp gave an index out of range");
      triangle[k] = base + static_cast<int>(face.mIndices[k]);
    }
    mesh->triangles.push_back(triangle);
  }
}

}  // namespace

RawMesh read_with_assimp(const std::filesystem::path& file, const std::string& bytes,
                         const std::string& format) {
  if (format == "stl") check_stl_end(file, bytes);
  Assimp::Importer importer;
  // No axis change, no scaling, no joining: mesh.cpp joins by position over all parts.
  const aiScene* scene =
      importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, format.c_str());
  if (scene == nullptr)
    throw UserError(ExitCode::input, file.string(),
                    fmt::format("is no {} mesh that can be read, or is truncated ({})", format,
                                importer.GetErrorString()));
  RawMesh mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) append(*scene->mMeshes[i], &mesh);
  // Both readers give every face its own corners.
  mesh.vertex_name = [](std::size_t i) { return fmt::format("corner {} (3 to a triangle)", i); };
  return mesh;
}

}  // namespace fringetwin
