// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdint>
#include <cstring>

#include "twin/base/plain_text.hpp"
#include "twin/mesh/mesh_file.hpp"

namespace fringetwin {
namespace {

constexpr std::size_t kStlHead = 84, kStlFacet = 50;  // bytes of a binary STL
constexpr std::size_t kStlNormal = 12;                // at the start of a facet

/// Appends the triangle of the last three vertices.
void add_facet(RawMesh* mesh) {
  const int end = static_cast<int>(mesh->vertices.size());
  mesh->add_polygon({end - 3, end - 2, end - 1});
}

std::size_t announced_facets(const std::string& bytes) {
  std::uint32_t facets = 0;
  if (bytes.size() >= kStlHead)
    std::memcpy(&facets, bytes.data() + kStlHead - 4, 4);  // little-endian, as amd64 is
  return facets;
}

std::size_t binary_bytes(const std::string& start) { return kStlHead + kStlFacet * announced_facets(start); }

/// Binary files may begin with "solid", too.
bool is_ascii_stl(const std::string& start, std::uintmax_t file_bytes) {
  return start.starts_with("solid") && file_bytes != binary_bytes(start);
}

void read_binary_stl(const std::string& bytes, RawMesh* mesh) {
  const std::size_t facets = announced_facets(bytes);
  mesh->expect_vertices(3 * facets);
  for (std::size_t i = 0; i < facets; ++i) {
    heed_cancel(i);
    float corners[9];
    std::memcpy(corners, bytes.data() + kStlHead + kStlFacet * i + kStlNormal, sizeof corners);
    for (int k = 0; k < 9; k += 3) mesh->add_vertex({corners[k], corners[k + 1], corners[k + 2]});
    add_facet(mesh);
  }
}

class AsciiStl {
 public:
  AsciiStl(const std::string& bytes, RawMesh* mesh) : text_(bytes), mesh_(*mesh) {}

  void read() {
    while (true) {
      const std::string_view word = text_.next_word();
      if (word.empty()) break;
      take(word);
    }
    if (!ended_) mesh_.refuse("is truncated (an ASCII STL without endsolid)");
    if (corners_ != 0) mesh_.refuse("has corners behind its last endfacet, which are of no facet");
  }

 private:
  void take(std::string_view word) {
    if (word == "solid" || word == "endsolid") {
      ended_ = word == "endsolid";
      text_.skip_line();
    } else if (word == "normal") {  // not read: some programs write words for what is no number
      for (int k = 0; k < 3; ++k) text_.next_word();
    } else if (word == "vertex") {
      take_vertex();
    } else if (word == "endfacet") {
      if (corners_ != 3)
        mesh_.refuse(fmt::format("has a facet of {} corners, it ends in line {}", corners_, text_.line()));
      corners_ = 0;
      add_facet(&mesh_);
    } else if (word != "facet" && word != "outer" && word != "loop" && word != "endloop") {
      mesh_.refuse(
          fmt::format("has {} in line {}, which is no word of an STL", quoted_excerpt(word), text_.line()));
    }
  }

  void take_vertex() {
    Eigen::Vector3d vertex;
    for (double& coordinate : vertex) {
      const std::string_view word = text_.next_word();
      const std::optional<double> number = mesh_number(word);
      if (!number)
        mesh_.refuse(
            fmt::format("has {} where a number is needed, in line {}", quoted_excerpt(word), text_.line()));
      coordinate = *number;
    }
    mesh_.add_vertex(vertex);
    ++corners_;
  }

  MeshText text_;
  RawMesh& mesh_;
  std::size_t corners_ = 0;  ///< of the facet so far
  bool ended_ = false;
};

}  // namespace

void check_stl_header(const std::filesystem::path& file, const MeshStart& start) {
  const MeshRefusal refuse(file);
  if (is_ascii_stl(start.bytes, start.file_bytes)) {
    if (start.bytes.size() < start.file_bytes && start.bytes.find("facet") == std::string::npos)
      refuse(fmt::format("is no STL (it has no facet in its first {} bytes)", start.bytes.size()));
    return;
  }
  const std::size_t facets = announced_facets(start.bytes);
  if (start.file_bytes != binary_bytes(start.bytes))
    refuse(fmt::format("is truncated or no STL (a binary STL of {} facets has {} bytes, this file {})",
                       facets, binary_bytes(start.bytes), start.file_bytes));
  check_vertex_count(3 * facets, refuse);
}

RawMesh read_stl(const std::filesystem::path& file, const std::string& bytes) {
  RawMesh mesh(file);
  mesh.vertex_name = [](std::size_t i) { return fmt::format("corner {} (3 to a triangle)", i); };
  if (is_ascii_stl(bytes, bytes.size()))
    AsciiStl(bytes, &mesh).read();
  else
    read_binary_stl(bytes, &mesh);
  return mesh;
}

}  // namespace fringetwin
