// SPDX-License-Identifier: Apache-2.0
#include "render/scene/mesh_geometry.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/scene/bvh_cache.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr std::size_t kCoveringSpheres = 64;

void add_box(std::vector<Eigen::Vector4f>& spheres, const Eigen::Vector3f& lo, const Eigen::Vector3f& hi) {
  const Eigen::Vector3f c = 0.5F * (lo + hi);
  spheres.emplace_back(c.x(), c.y(), c.z(), (0.5F * (hi - lo)).norm());
}

// Returns spheres around the boxes of the tree's top, of the widest level that stays within kCoveringSpheres.
std::vector<Eigen::Vector4f> cover(const Bvh& bvh) {
  std::vector<std::int32_t> level{0};
  std::vector<Eigen::Vector4f> spheres;
  while (!level.empty() && spheres.size() + 4 * level.size() <= kCoveringSpheres) {
    std::vector<std::int32_t> next;
    for (const std::int32_t i : level)
      for (const bool left : {true, false}) {
        const BvhNode& n = bvh.nodes[i];
        const std::int32_t child = left ? n.left : n.right;
        if (child >= 0)
          next.push_back(child);
        else if (n.left_min.x() <= n.left_max.x() && (left || n.right_min.x() <= n.right_max.x()))
          left ? add_box(spheres, n.left_min, n.left_max) : add_box(spheres, n.right_min, n.right_max);
      }
    level = std::move(next);
  }
  for (const std::int32_t i : level) {
    const BvhNode& n = bvh.nodes[i];
    add_box(spheres, n.left_min.cwiseMin(n.right_min), n.left_max.cwiseMax(n.right_max));
  }
  return spheres;
}

// Returns the middle of a coordinate's range if that makes the numbers smaller, on the raster of the range's
// largest float: subtracting it is then exact. A rounded vertex would tilt a sliver.
double exact_center(double lo, double hi) {
  const double middle = 0.5 * (lo + hi);
  if (std::abs(middle) <= hi - lo) return 0.0;
  const auto largest = static_cast<float>(std::max(std::abs(lo), std::abs(hi)));
  const double raster = std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest;
  return std::round(middle / raster) * raster;
}

// Returns twice the area vector of a triangle, in double precision: exact for all but extreme ratios of the
// coordinates.
Eigen::Vector3d area_vector(const Mesh& mesh, const std::array<int, 3>& triangle) {
  const auto v = [&](std::size_t k) -> Eigen::Vector3d {
    return mesh.vertices_mm[triangle[k]].cast<double>();
  };
  return (v(1) - v(0)).cross(v(2) - v(0));
}

// Returns the triangles that can be hit: one without area has no inside.
std::vector<std::array<int, 3>> with_area(const Mesh& mesh) {
  std::vector<std::array<int, 3>> out;
  out.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    if (area_vector(mesh, t).squaredNorm() > 0.0) out.push_back(t);
  return out;
}

void check_mesh(const Mesh& mesh, const std::string& name) {
  for (std::size_t i = 0; i < mesh.vertices_mm.size(); ++i)
    if (!mesh.vertices_mm[i].allFinite())
      throw UserError(ExitCode::input, name,
                      fmt::format("vertex {} has a coordinate that is no finite number", i),
                      "repair the mesh");
}

}  // namespace

MeshGeometry build_mesh_geometry(std::shared_ptr<const Mesh> mesh, const std::string& name) {
  FT_CHECK(mesh != nullptr, "no mesh");
  check_mesh(*mesh, name);
  const std::vector<std::array<int, 3>> triangles = with_area(*mesh);
  if (triangles.empty()) throw UserError(ExitCode::input, name, "the mesh has no triangle with an area");
  MeshGeometry g;
  Eigen::Vector3f lo = mesh->vertices_mm.front(), hi = lo;
  for (const Eigen::Vector3f& v : mesh->vertices_mm) {
    lo = lo.cwiseMin(v);
    hi = hi.cwiseMax(v);
  }
  for (int k = 0; k < 3; ++k) g.center_mm[k] = exact_center(lo[k], hi[k]);
  std::vector<Eigen::Vector3f> vertices(mesh->vertices_mm.size());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    vertices[i] = (mesh->vertices_mm[i].cast<double>() - g.center_mm).cast<float>();
  g.bvh = cached_bvh(vertices, triangles, STACK_SIZE, cache_folder());
  g.covering = cover(g.bvh);

  const std::vector<Eigen::Vector3f> normals =
      mesh->vertex_normals.empty() ? compute_vertex_normals(*mesh) : mesh->vertex_normals;
  const auto n = static_cast<int>(g.bvh.order.size());
  g.triangles.resize(3 * g.bvh.order.size());
  g.corners.resize(3 * g.bvh.order.size());
  g.indices.resize(g.bvh.order.size());
#pragma omp parallel for
  for (int i = 0; i < n; ++i) {
    const auto& triangle = triangles[g.bvh.order[i]];
    const Eigen::Vector3f normal = area_vector(*mesh, triangle).normalized().cast<float>();
    g.indices[i] = triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(triangle[k]);
      const std::size_t slot = 3 * static_cast<std::size_t>(i) + k;
      const float albedo = mesh->vertex_albedo.empty() ? 1.0F : mesh->vertex_albedo[v];
      g.triangles[slot] = {vertices[v].x(), vertices[v].y(), vertices[v].z(), normal[static_cast<int>(k)]};
      g.corners[slot] = {normals[v].x(), normals[v].y(), normals[v].z(), albedo};
    }
  }
  g.vertices = std::move(vertices);
  g.mesh = std::move(mesh);
  return g;
}

double winding_number(const Mesh& mesh, const Eigen::Vector3d& point_mm) {
  double solid_angle = 0.0;
  for (const auto& t : mesh.triangles) {
    Eigen::Vector3d v[3];
    for (std::size_t k = 0; k < 3; ++k) v[k] = mesh.vertices_mm[t[k]].cast<double>() - point_mm;
    const double a = v[0].norm(), b = v[1].norm(), c = v[2].norm();
    const double numerator = v[0].dot(v[1].cross(v[2]));
    const double denominator = a * b * c + v[0].dot(v[1]) * c + v[1].dot(v[2]) * a + v[2].dot(v[0]) * b;
    solid_angle += 2.0 * std::atan2(numerator, denominator);
  }
  return solid_angle / (4.0 * std::numbers::pi);
}

const MeshGeometry& MeshStore::get(const std::shared_ptr<const Mesh>& mesh, const std::string& name) {
  for (const auto& m : meshes_)
    if (m->mesh == mesh) return *m;
  // Meshes nobody else holds any more make room.
  std::erase_if(meshes_, [](const auto& m) { return m->mesh.use_count() == 1; });
  meshes_.push_back(std::make_unique<MeshGeometry>(build_mesh_geometry(mesh, name)));
  return *meshes_.back();
}

}  // namespace fringetwin::render
