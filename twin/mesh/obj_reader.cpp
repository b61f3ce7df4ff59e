// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <utility>

#include "twin/base/plain_text.hpp"
#include "twin/mesh/mesh_file.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin {
namespace {

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& file, const std::string& bytes) : text_(bytes), mesh_(file) {
    mesh_.vertex_name = [](std::size_t i) { return fmt::format("vertex {}", i + 1); };
    mesh_.drops_lonely_vertices = true;  // of points, lines and curves; they would count in the mesh's middle
  }

  RawMesh read() {
    do {
      const std::string_view keyword = text_.next_word_in_line();
      if (keyword == "v")
        take_vertex();
      else if (keyword == "f")
        take_face();
      else if (keyword == "l" || keyword == "p")
        ++mesh_.other_faces;
    } while (text_.skip_line());
    add_faces();
    return std::move(mesh_);
  }

 private:
  /// Returns the statement's next word; a backslash at the end of a line continues it in the next, a comment
  /// ends it.
  std::string_view next_word() {
    while (true) {
      std::string_view word = text_.next_word_in_line();
      if (word.starts_with('#')) return {};
      if (!word.ends_with('\\')) return word;
      word.remove_suffix(1);
      if (!text_.skip_line() || !word.empty()) return word;
    }
  }

  [[noreturn]] void refuse_word(std::string_view word, const char* what) {
    mesh_.refuse(
        fmt::format("has {} where {} is needed, in line {}", quoted_excerpt(word), what, text_.line()));
  }

  void take_vertex() {
    Eigen::Vector4d numbers(0.0, 0.0, 0.0, 1.0);
    Eigen::Index n = 0;
    // What follows is a weight of its own, or a colour of three numbers.
    for (std::string_view word = next_word(); !word.empty(); word = next_word(), ++n) {
      if (n >= 4) continue;
      const std::optional<double> number = mesh_number(word);
      if (!number) refuse_word(word, "a number");
      numbers[n] = *number;
    }
    if (n < 3) mesh_.refuse(fmt::format("has {} numbers where a vertex has 3, in line {}", n, text_.line()));
    Eigen::Vector3d vertex = numbers.head<3>();
    if (n == 4) vertex /= numbers[3];
    mesh_.add_vertex(vertex);
  }

  /// Takes "7", "7/1", "7//3" or "7/1/3": only the vertex counts. A negative one counts back from the last.
  void take_face() {
    for (std::string_view word = next_word(); !word.empty(); word = next_word()) {
      const auto index = parse_number<std::int64_t>(word.substr(0, word.find('/')));
      if (!index) refuse_word(word, "a vertex");
      const auto n_vertices = static_cast<std::int64_t>(mesh_.vertices.size());
      const std::int64_t corner = *index < 0 ? n_vertices + *index : *index - 1;
      if (corner < 0 || corner > std::numeric_limits<int>::max())
        mesh_.refuse(
            fmt::format("names vertex {} in line {}, there are {} so far", *index, text_.line(), n_vertices));
      corners_.push_back(static_cast<int>(corner));
    }
    ends_.push_back(corners_.size());
  }

  /// A face may name vertices of later lines, so that it can be cut only when all are read.
  void add_faces() {
    std::vector<int> polygon;
    std::size_t first = 0;
    for (std::size_t face = 0; face < ends_.size(); ++face) {
      heed_cancel(face);
      polygon.assign(corners_.begin() + static_cast<std::ptrdiff_t>(first),
                     corners_.begin() + static_cast<std::ptrdiff_t>(ends_[face]));
      for (const int corner : polygon)
        if (static_cast<std::size_t>(corner) >= mesh_.vertices.size())
          mesh_.refuse(fmt::format("names vertex {} in its face {}, there are {}", corner + 1LL, face + 1,
                                   mesh_.vertices.size()));
      mesh_.add_polygon(polygon);
      first = ends_[face];
    }
  }

  MeshText text_;
  RawMesh mesh_;
  std::vector<int> corners_;       ///< of all faces, one after the other
  std::vector<std::size_t> ends_;  ///< of each face in corners_
};

}  // namespace

RawMesh read_obj(const std::filesystem::path& file, const std::string& bytes) {
  return ObjReader(file, bytes).read();
}

}  // namespace fringetwin
