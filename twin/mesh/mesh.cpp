// SPDX-License-Identifier: Apache-2.0
#include "twin/mesh/mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cstdint>
#include <unordered_map>

#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/mesh/mesh_file.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

/// Editors put a UTF-8 byte order mark before text; no mesh format knows it. Returns its size where it was.
std::size_t drop_byte_order_mark(std::string* bytes) {
  if (!bytes->starts_with(kByteOrderMark)) return 0;
  bytes->erase(0, kByteOrderMark.size());
  return kByteOrderMark.size();
}

struct Format {
  void (*check_header)(const fs::path& file, const MeshStart& start);
  RawMesh (*read)(const fs::path& file, const std::string& bytes);
};

/// An OBJ has no header; but it is text.
void check_obj_start(const fs::path& file, const MeshStart& start) {
  if (start.bytes.find('\0') != std::string::npos)
    throw UserError(ExitCode::input, file.string(), "is no OBJ (it has a byte 0 near its begin)");
}

Format format_of(const fs::path& file, const std::string& start) {
  if (start.starts_with("ply\n") || start.starts_with("ply\r")) return {check_ply_header, read_ply};
  const std::string extension = lower_extension(file);
  if (extension == ".stl") return {check_stl_header, read_stl};
  if (extension == ".obj") return {check_obj_start, read_obj};
  throw UserError(ExitCode::input, file.string(), "is no mesh of a known format",
                  "PLY, STL and OBJ are read");
}

RawMesh read_raw(const fs::path& file) {
  const FileUse use = {.kind = FileKind::mesh, .what = "mesh", .hint = "check the name and the folder"};
  MeshStart start;
  start.bytes = read_text_start(file, use, kMostMeshStart + kByteOrderMark.size(), &start.file_bytes);
  if (start.bytes.empty()) throw UserError(ExitCode::input, file.string(), "is empty (0 bytes)");
  start.file_bytes -= drop_byte_order_mark(&start.bytes);
  const Format format = format_of(file, start.bytes);
  format.check_header(file, start);
  if (start.bytes.size() < start.file_bytes) {
    start.bytes = read_whole_text(file, use);
    drop_byte_order_mark(&start.bytes);
    start.file_bytes = start.bytes.size();
    format.check_header(file, start);  // another program may have written it since
  }
  return format.read(file, start.bytes);
}

/// Returns the vertex as float mm. What is finite in the file may not be after scaling and rounding; and
/// beyond 1e9 mm products of coordinates leave the range of float.
Eigen::Vector3f checked_vertex(const fs::path& file, const RawMesh& raw, std::size_t i, double scale) {
  constexpr float kLargestMm = 1e9f;
  const Eigen::Vector3d& v = raw.vertices[i];
  const Eigen::Vector3f p = (v * scale).cast<float>();
  if (p.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kLargestMm) return p;
  const std::string what =
      v.allFinite() ? fmt::format("beyond {:g} mm", kLargestMm) : "that is no finite number";
  throw UserError(
      ExitCode::input, file.string(),
      fmt::format("{} has a coordinate {}: ({}, {}, {})", raw.vertex_name(i), what, v.x(), v.y(), v.z()),
      v.allFinite() ? "check its unit" : "mend the mesh");
}

struct VertexKey {
  std::array<std::uint32_t, 4> bits;
  bool operator==(const VertexKey&) const = default;
};
struct VertexHash {
  std::size_t operator()(const VertexKey& key) const {
    std::uint64_t hash = 0;
    for (const std::uint32_t b : key.bits) {  // splitmix64's finaliser over each word
      hash = (hash ^ b) + 0x9e3779b97f4a7c15u;
      hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
      hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
      hash ^= hash >> 31;
    }
    return hash;
  }
};

/// Fills vertices (and albedo); returns the new index of every raw vertex that is not dropped.
std::vector<int> join_vertices(const fs::path& file, const RawMesh& raw, double scale, Mesh* mesh) {
  std::unordered_map<VertexKey, int, VertexHash> known;
  known.reserve(raw.vertices.size());
  std::vector<bool> is_dropped(raw.vertices.size(), raw.drops_lonely_vertices);
  for (const std::array<int, 3>& triangle : raw.triangles)
    for (const int corner : triangle) is_dropped[corner] = false;
  std::vector<int> index_of(raw.vertices.size());
  for (std::size_t i = 0; i < raw.vertices.size(); ++i) {
    heed_cancel(i);
    const Eigen::Vector3f p = checked_vertex(file, raw, i, scale);
    if (is_dropped[i]) continue;
    const float albedo = raw.albedo.empty() ? 1.0f : raw.albedo[i];
    // + 0 makes -0 and 0 the same
    const VertexKey key{{std::bit_cast<std::uint32_t>(p.x() + 0.0f),
                         std::bit_cast<std::uint32_t>(p.y() + 0.0f),
                         std::bit_cast<std::uint32_t>(p.z() + 0.0f), std::bit_cast<std::uint32_t>(albedo)}};
    const auto [it, is_new] = known.try_emplace(key, static_cast<int>(mesh->vertices_mm.size()));
    if (is_new) {
      mesh->vertices_mm.push_back(p);
      if (!raw.albedo.empty()) mesh->vertex_albedo.push_back(albedo);
    }
    index_of[i] = it->second;
  }
  return index_of;
}

/// A height below 1e-10 of the longest side: far below what float coordinates (6e-8) can tell from 0.
bool is_degenerate(const Mesh& mesh, const std::array<int, 3>& t) {
  const auto vertex = [&](int k) -> Eigen::Vector3d { return mesh.vertices_mm[t[k]].cast<double>(); };
  const Eigen::Vector3d ab = vertex(1) - vertex(0), ac = vertex(2) - vertex(0), bc = vertex(2) - vertex(1);
  const double longest_sq = std::max({ab.squaredNorm(), ac.squaredNorm(), bc.squaredNorm()});
  return ab.cross(ac).norm() <= 1e-10 * longest_sq;
}

}  // namespace

std::shared_ptr<const Mesh> load_mesh(const fs::path& file, const std::string& unit) {
  FT_CHECK(unit == "mm" || unit == "m", "unit " + unit);
  const RawMesh raw = read_raw(file);
  auto mesh = std::make_shared<Mesh>();
  const std::vector<int> index_of = join_vertices(file, raw, unit == "m" ? 1000.0 : 1.0, mesh.get());
  std::size_t degenerate = 0;
  for (std::size_t i = 0; i < raw.triangles.size(); ++i) {
    heed_cancel(i);
    std::array<int, 3> triangle = raw.triangles[i];
    for (int& corner : triangle) corner = index_of[corner];
    if (is_degenerate(*mesh, triangle))
      ++degenerate;
    else
      mesh->triangles.push_back(triangle);
  }
  if (mesh->triangles.empty())
    throw UserError(ExitCode::input, file.string(),
                    degenerate > 0 ? fmt::format("has no triangle with an area ({} without)", degenerate)
                                   : "has no triangle",
                    "a mesh of triangles or polygons is needed");
  if (degenerate > 0) warn(fmt::format("{}: {} triangles without area left out", file.string(), degenerate));
  if (raw.other_faces > 0)
    warn(fmt::format("{}: {} points or lines left out", file.string(), raw.other_faces));
  return mesh;
}

std::vector<Eigen::Vector3f> compute_vertex_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> sums(mesh.vertices_mm.size(), Eigen::Vector3d::Zero());
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    const auto vertex = [&](std::size_t k) -> Eigen::Vector3d {
      return mesh.vertices_mm[triangle[k]].cast<double>();
    };
    // the cross product's length is twice the area: the weight
    const Eigen::Vector3d normal = (vertex(1) - vertex(0)).cross(vertex(2) - vertex(0));
    for (const int corner : triangle) sums[corner] += normal;
  }
  std::vector<Eigen::Vector3f> normals(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double length = sums[i].norm();
    // a vertex without a triangle is never shaded; it still gets a unit vector
    normals[i] = length > 0.0 ? (sums[i] / length).cast<float>().eval() : Eigen::Vector3f::UnitZ().eval();
  }
  return normals;
}

}  // namespace fringetwin
