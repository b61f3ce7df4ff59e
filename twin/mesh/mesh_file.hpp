// SPDX-License-Identifier: Apache-2.0
// Reads what a mesh file holds, before mesh.cpp scales, joins and cleans it. The readers are our own: those
// of assimp 5.2 write and read beyond their buffers, and open what an OBJ file names.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/base/progress.hpp"

namespace fringetwin {

/// Refuses a mesh file: throws UserError(input) that names it.
class MeshRefusal {
 public:
  explicit MeshRefusal(const std::filesystem::path& file) : file_(file.string()) {}
  [[noreturn]] void operator()(const std::string& what, const std::string& hint = "") const;

 private:
  std::string file_;
};

struct RawMesh {
  explicit RawMesh(const std::filesystem::path& file);

  void expect_vertices(std::size_t count);         ///< makes room for them; refuses too many
  void add_vertex(const Eigen::Vector3d& vertex);  ///< refuses too many as well
  /// Appends the triangles of a polygon whose vertices are there; counts one of fewer than three corners.
  void add_polygon(const std::vector<int>& corners);

  MeshRefusal refuse;
  std::vector<Eigen::Vector3d> vertices;  ///< in the file's unit; NaN and infinity not yet refused
  std::vector<float> albedo;              ///< one per vertex, or empty
  std::vector<std::array<int, 3>> triangles;
  std::size_t other_faces = 0;                          ///< points and lines, left out
  bool drops_lonely_vertices = false;                   ///< those of no triangle
  std::function<std::string(std::size_t)> vertex_name;  ///< how the file counts its vertices
  double corner_tests_left;                             ///< how much cutting of concave polygons is left

 private:
  void add_fan(const std::vector<int>& corners);
  void add_triangle(const std::array<int, 3>& triangle);
  bool is_convex(const std::vector<int>& corners) const;
  void clip_ears(const std::vector<int>& corners);
};

/// Refuses more vertices than three for each triangle that can be traced.
void check_vertex_count(std::size_t count, const MeshRefusal& refuse);

/// The beginning of a mesh file, in which its header ends, or all of it.
struct MeshStart {
  std::string bytes;
  std::uintmax_t file_bytes;
};
constexpr std::size_t kMostMeshStart = (1 << 20) + 1;  // bytes

/// Refuse what the header of a file is wrong in, before the file is read.
void check_ply_header(const std::filesystem::path& file, const MeshStart& start);
void check_stl_header(const std::filesystem::path& file, const MeshStart& start);

/// Reads ASCII and binary PLY of either byte order. Ignores normals, colours, other properties and elements.
/// Throws UserError(input).
RawMesh read_ply(const std::filesystem::path& file, const std::string& bytes);
/// Reads ASCII and binary STL. Throws UserError(input).
RawMesh read_stl(const std::filesystem::path& file, const std::string& bytes);
/// Reads the vertices and polygons of an OBJ and nothing else; opens no other file. Throws UserError(input).
RawMesh read_obj(const std::filesystem::path& file, const std::string& bytes);

/// Lets the user's Ctrl-C end a loop over the entries of a file: called with each one's number.
inline void heed_cancel(std::size_t number) {
  if (number % 65536 == 0) throw_if_cancelled();
}

/// The words of a text, one by one, never beyond its end; Ctrl-C ends them.
class MeshText {
 public:
  explicit MeshText(std::string_view text, std::size_t position = 0) : text_(text), position_(position) {}
  /// Returns the next word, wherever it is; empty at the end of the text.
  std::string_view next_word();
  /// Returns the next word before the line's end, else an empty one.
  std::string_view next_word_in_line();
  /// Goes behind the next line break; false where there is none, at the text's end.
  bool skip_line();
  std::size_t position() const { return position_; }
  std::size_t line() const { return line_; }  ///< from 1

 private:
  std::string_view text_;
  std::size_t position_, line_ = 1, words_ = 0;
};

/// Returns the number that a word writes, infinity beyond the range of double; nullopt if it is no number.
std::optional<double> mesh_number(std::string_view word);

}  // namespace fringetwin
