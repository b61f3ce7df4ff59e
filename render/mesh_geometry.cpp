// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "render/scene.hpp"
#include "twin/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr std::size_t covering_spheres = 64;

void add_box(std::vector<Eigen::Vector4f>& spheres, const Eigen::Vector3f& lo, const Eigen::Vector3f& hi) {
  const Eigen::Vector3f c = 0.5F * (lo + hi);
  spheres.emplace_back(c.x(), c.y(), c.z(), (0.5F * (hi - lo)).norm());
}

// Boxes of the top of the tree, widest level that stays within covering_spheres.
std::vector<Eigen::Vector4f> cover(const Bvh& bvh) {
  std::vector<std::int32_t> level{0};
  std::vector<Eigen::Vector4f> spheres;
  while (!level.empty() && spheres.size() + 4 * level.size() <= covering_spheres) {
    std::vector<std::int32_t> next;
    for (const std::int32_t i : level)
      for (const bool left : {true, false}) {
        const BvhNode& n = bvh.nodes[static_cast<std::size_t>(i)];
        const std::int32_t child = left ? n.left : n.right;
        if (child >= 0)
          next.push_back(child);
        else if (n.left_min.x() <= n.left_max.x() && (left || n.right_min.x() <= n.right_max.x()))
          left ? add_box(spheres, n.left_min, n.left_max) : add_box(spheres, n.right_min, n.right_max);
      }
    level = std::move(next);
  }
  for (const std::int32_t i : level) {
    const BvhNode& n = bvh.nodes[static_cast<std::size_t>(i)];
    add_box(spheres, n.left_min.cwiseMin(n.right_min), n.left_max.cwiseMax(n.right_max));
  }
  return spheres;
}

}  // namespace

MeshGeometry build_mesh_geometry(std::shared_ptr<const Mesh> mesh) {
  FT_CHECK(mesh != nullptr && !mesh->triangles.empty(), "mesh without triangles");
  MeshGeometry g;
  Eigen::Vector3f lo = mesh->vertices_mm.front(), hi = lo;
  for (const Eigen::Vector3f& v : mesh->vertices_mm) {
    lo = lo.cwiseMin(v);
    hi = hi.cwiseMax(v);
  }
  g.center_mm = 0.5 * (lo.cast<double>() + hi.cast<double>());
  std::vector<Eigen::Vector3f> vertices(mesh->vertices_mm.size());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    vertices[i] = (mesh->vertices_mm[i].cast<double>() - g.center_mm).cast<float>();
  g.bvh = build_bvh(vertices, mesh->triangles, STACK_SIZE);
  g.covering = cover(g.bvh);

  const std::vector<Eigen::Vector3f> normals =
      mesh->vertex_normals.empty() ? compute_vertex_normals(*mesh) : mesh->vertex_normals;
  const auto n = static_cast<int>(g.bvh.order.size());
  g.triangles.resize(3 * g.bvh.order.size());
  g.corners.resize(3 * g.bvh.order.size());
#pragma omp parallel for
  for (int i = 0; i < n; ++i) {
    const auto& triangle = mesh->triangles[g.bvh.order[static_cast<std::size_t>(i)]];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(triangle[k]);
      const std::size_t slot = 3 * static_cast<std::size_t>(i) + k;
      const float albedo = mesh->vertex_albedo.empty() ? 1.0F : mesh->vertex_albedo[v];
      g.triangles[slot] = {vertices[v].x(), vertices[v].y(), vertices[v].z(), 0.0F};
      g.corners[slot] = {normals[v].x(), normals[v].y(), normals[v].z(), albedo};
    }
  }
  g.mesh = std::move(mesh);
  return g;
}

double winding_number(const Mesh& mesh, const Eigen::Vector3d& point_mm) {
  double solid_angle = 0.0;
  for (const auto& t : mesh.triangles) {
    Eigen::Vector3d v[3];
    for (std::size_t k = 0; k < 3; ++k)
      v[k] = mesh.vertices_mm[static_cast<std::size_t>(t[k])].cast<double>() - point_mm;
    const double a = v[0].norm(), b = v[1].norm(), c = v[2].norm();
    const double numerator = v[0].dot(v[1].cross(v[2]));
    const double denominator = a * b * c + v[0].dot(v[1]) * c + v[1].dot(v[2]) * a + v[2].dot(v[0]) * b;
    solid_angle += 2.0 * std::atan2(numerator, denominator);
  }
  return solid_angle / (4.0 * std::numbers::pi);
}

const MeshGeometry& MeshStore::get(const std::shared_ptr<const Mesh>& mesh) {
  for (const auto& m : meshes_)
    if (m->mesh == mesh) return *m;
  // Meshes nobody else holds any more make room.
  std::erase_if(meshes_, [](const auto& m) { return m->mesh.use_count() == 1; });
  meshes_.push_back(std::make_unique<MeshGeometry>(build_mesh_geometry(mesh)));
  return *meshes_.back();
}

}  // namespace fringetwin::render
