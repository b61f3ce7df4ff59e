// SPDX-License-Identifier: Apache-2.0
// What the readers of mesh files share: words, numbers, and polygons that become triangles.
#include "twin/mesh/mesh_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <limits>

#include "twin/base/errors.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/mesh/most_triangles.hpp"

namespace fringetwin {
namespace {

// A triangle of an STL has three vertices of its own.
constexpr std::size_t kMostMeshVertices = 3 * kMostTriangles;

// The clipping of ears takes up to the cube of the corners.
constexpr std::size_t kMostConcaveCorners = 2000;
// Whether a corner lies in an ear is asked so often for all polygons of a file: about a second. A polygon of
// n corners mostly takes the square of n, a million concave ones of ten corners a fifth of this.
constexpr double kMostCornerTests = 5e8;

// A corner bends inwards where its sine is below this: less is the rounding of coordinates in float.
constexpr double kInwards = -1e-6;

bool is_blank_in_line(char c) { return c == ' ' || (c >= '\t' && c <= '\r' && c != '\n'); }

/// Returns the vector around which the corners turn counter-clockwise, as long as twice the polygon's area.
Eigen::Vector3d polygon_normal(const std::vector<int>& corners,
                               const std::vector<Eigen::Vector3d>& vertices) {
  const Eigen::Vector3d& origin = vertices[corners[0]];
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t k = 2; k < corners.size(); ++k)
    normal += (vertices[corners[k - 1]] - origin).cross(vertices[corners[k]] - origin);
  return normal;
}

/// A polygon in the plane of two coordinates, counter-clockwise.
class FlatPolygon {
 public:
  FlatPolygon(const std::vector<int>& corners, const std::vector<Eigen::Vector3d>& vertices)
      : corners_(corners) {
    const Eigen::Vector3d normal = polygon_normal(corners, vertices);
    int axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    if (normal[axis] < 0.0) std::swap(u, v);
    const Eigen::Vector3d& origin = vertices[corners[0]];
    for (const int corner : corners) {
      const Eigen::Vector3d p = vertices[corner] - origin;
      points_.emplace_back(p[u], p[v]);
    }
  }

  std::size_t size() const { return corners_.size(); }
  const std::vector<int>& corners() const { return corners_; }
  std::array<int, 3> triangle_at(std::size_t k) const {
    return {corners_[before(k)], corners_[k], corners_[after(k)]};
  }

  /// Whether nothing else of the polygon lies in the triangle of a corner and its neighbours. Takes the
  /// corners that it has asked from `tests_left`.
  bool is_ear(std::size_t k, double* tests_left) const {
    const Eigen::Vector2d &a = points_[before(k)], &b = points_[k], &c = points_[after(k)];
    *tests_left -= 1.0;
    if (!(turn(a, b, c) > 0.0)) return false;
    const auto inside = std::ranges::find_if(points_, [&](const Eigen::Vector2d& p) {
      return p != a && p != b && p != c && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 &&
             turn(c, a, p) >= 0.0;
    });
    *tests_left -= static_cast<double>(inside - points_.begin());
    return inside == points_.end();
  }

  void cut(std::size_t k) {
    corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(k));
    points_.erase(points_.begin() + static_cast<std::ptrdiff_t>(k));
  }

 private:
  std::size_t before(std::size_t k) const { return (k + size() - 1) % size(); }
  std::size_t after(std::size_t k) const { return (k + 1) % size(); }
  static double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b - a).x() * (c - b).y() - (b - a).y() * (c - b).x();
  }

  std::vector<int> corners_;
  std::vector<Eigen::Vector2d> points_;
};

}  // namespace

void MeshRefusal::operator()(const std::string& what, const std::string& hint) const {
  throw UserError(ExitCode::input, file_, what, hint);
}

void check_vertex_count(std::size_t count, const MeshRefusal& refuse) {
  if (count > kMostMeshVertices)
    refuse(fmt::format("has more than {} vertices", kMostMeshVertices), "reduce the mesh");
}

RawMesh::RawMesh(const std::filesystem::path& file)
    : refuse(file), corner_tests_left(kMostCornerTests * file_limits_factor()) {}

void RawMesh::expect_vertices(std::size_t count) {
  check_vertex_count(count, refuse);
  vertices.reserve(count);
}

void RawMesh::add_vertex(const Eigen::Vector3d& vertex) {
  if (vertices.size() == kMostMeshVertices) expect_vertices(vertices.size() + 1);
  vertices.push_back(vertex);
}

void RawMesh::add_polygon(const std::vector<int>& corners) {
  if (corners.size() < 3)
    ++other_faces;
  else if (corners.size() == 3 || is_convex(corners))
    add_fan(corners);
  else if (corners.size() <= kMostConcaveCorners)
    clip_ears(corners);
  else
    refuse(fmt::format("has a concave polygon of {} corners, at most {} are cut into triangles",
                       corners.size(), kMostConcaveCorners),
           "let the program that wrote it cut its polygons");
}

void RawMesh::add_fan(const std::vector<int>& corners) {
  for (std::size_t k = 2; k < corners.size(); ++k) add_triangle({corners[0], corners[k - 1], corners[k]});
}

void RawMesh::add_triangle(const std::array<int, 3>& triangle) {
  if (triangles.size() == kMostTriangles)
    refuse(fmt::format("has more than {} triangles, no more can be traced", kMostTriangles),
           "reduce the mesh");
  triangles.push_back(triangle);
}

bool RawMesh::is_convex(const std::vector<int>& corners) const {
  const Eigen::Vector3d normal = polygon_normal(corners, vertices);
  const std::size_t n = corners.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d& middle = vertices[corners[(k + 1) % n]];
    const Eigen::Vector3d in = middle - vertices[corners[k]];
    const Eigen::Vector3d out = vertices[corners[(k + 2) % n]] - middle;
    if (!(in.cross(out).dot(normal) >= kInwards * in.norm() * out.norm() * normal.norm())) return false;
  }
  return true;
}

/// Cuts off one ear after the other: a corner whose triangle holds nothing of the polygon (a polygon that
/// does not cross itself always has one). What has none becomes a fan.
void RawMesh::clip_ears(const std::vector<int>& corners) {
  FlatPolygon polygon(corners, vertices);
  std::size_t at = 0, tried = 0;
  while (polygon.size() > 3 && tried < polygon.size()) {
    throw_if_cancelled();
    if (polygon.is_ear(at, &corner_tests_left)) {
      add_triangle(polygon.triangle_at(at));
      polygon.cut(at);
      tried = 0;
    } else {
      ++tried;
    }
    if (corner_tests_left < 0.0)
      refuse("has concave polygons that take too long to be cut into triangles",
             "let the program that wrote it cut its polygons, or see --limits");
    at = (at + 1) % polygon.size();
  }
  add_fan(polygon.corners());
}

std::string_view MeshText::next_word() {
  std::string_view word = next_word_in_line();
  while (word.empty() && skip_line()) word = next_word_in_line();
  return word;
}

std::string_view MeshText::next_word_in_line() {
  heed_cancel(words_++);
  while (position_ < text_.size() && is_blank_in_line(text_[position_])) ++position_;
  const std::size_t first = position_;
  while (position_ < text_.size() && !is_blank_in_line(text_[position_]) && text_[position_] != '\n')
    ++position_;
  return text_.substr(first, position_ - first);
}

bool MeshText::skip_line() {
  const std::size_t end = text_.find('\n', position_);
  position_ = end == std::string_view::npos ? text_.size() : end + 1;
  ++line_;
  return end != std::string_view::npos;
}

std::optional<double> mesh_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (stop != end || word.empty()) return std::nullopt;
  if (error != std::errc::result_out_of_range) return value;
  // from_chars does not say on which side of the range the number is.
  const bool tiny = word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos;
  return tiny ? 0.0 : std::numeric_limits<double>::infinity();
}

}  // namespace fringetwin
