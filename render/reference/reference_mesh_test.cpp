// SPDX-License-Identifier: Apache-2.0
// The reference's meshes: Embree's candidates against testing every triangle, and known surfaces.
// | tolerance | unit     | origin                                                                |
// |-----------|----------|-----------------------------------------------------------------------|
// | 0         | triangle | the same double-precision test decides on both paths                   |
// | 1e-9      | mm       | float vertices are exact here; rounding at 300 mm                       |
// | 1e-6      | relative | vertex normals are stored as float                                      |
#include "render/reference/reference_mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "render/reference/reference.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::render::reference_mesh_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double far_mm = 1e9;

std::shared_ptr<const Mesh> bumpy(int subdivisions, double radius_mm = 35.0) {
  return std::make_shared<Mesh>(
      testing::make_bumpy_icosphere(subdivisions, radius_mm, testing::default_bumps()));
}
/// A square of 2 x 2 triangles in z = 0, side 2 * half, x to the right, y down, facing -z.
std::shared_ptr<Mesh> square(float half) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices_mm = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  mesh->triangles = {{0, 2, 1}, {0, 3, 2}};
  return mesh;
}
MeshShape mesh_shape(std::shared_ptr<const Mesh> mesh, const Vector3d& at_mm, bool smooth = false) {
  return {{}, "mm", {Eigen::Matrix3d::Identity(), at_mm}, smooth, std::move(mesh)};
}

struct RandomRays {
  std::mt19937_64 random{11};
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); }
  Vector3d direction() {
    std::normal_distribution<double> n;
    return Vector3d(n(random), n(random), n(random)).normalized();
  }
};

TEST(Freeform, EightyOneThousandTrianglesOnTheTrueSurface) {
  const auto mesh = bumpy(6);
  EXPECT_EQ(mesh->triangles.size(), 81920u);
  EXPECT_EQ(mesh->vertices_mm.size(), 40962u);  // Euler: V - E + F = 2 with E = 1.5 F
  double volume = 0.0;
  for (const auto& [a, b, c] : mesh->triangles) {
    const auto v = [&](int i) {
      return Vector3d(mesh->vertices_mm[static_cast<std::size_t>(i)].cast<double>());
    };
    const double six_volumes = v(a).dot(v(b).cross(v(c)));
    EXPECT_GT(six_volumes, 0.0);  // star-shaped and wound outwards
    volume += six_volumes / 6;
  }
  EXPECT_NEAR(std::cbrt(volume * 3 / 4 / M_PI), 35.0, 2.0);
  for (const auto& v : mesh->vertices_mm) {
    const Vector3d p = v.cast<double>();
    EXPECT_NEAR(p.norm(), testing::bumpy_radius(35.0, testing::default_bumps(), p.normalized()), 1e-5);
  }
}

TEST(ReferenceMeshTest, EmbreeFindsWhatTestingEveryTriangleFinds) {
  const auto mesh = bumpy(3);
  const ReferenceMesh reference(mesh, 300.0);
  RandomRays rays;
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d origin = rays.uniform(50, 300) * rays.direction();
    const Vector3d target = rays.uniform(0, 45) * rays.direction();
    const Ray ray{origin, (target - origin).normalized()};
    const double t_max = i % 3 == 0 ? rays.uniform(10, 300) : far_mm;
    const auto a = reference.nearest(ray, 0.0, t_max), b = reference.nearest_brute_force(ray, 0.0, t_max);
    ASSERT_EQ(a.has_value(), b.has_value()) << i;
    EXPECT_EQ(reference.occluded(ray, 0.0, t_max, -1), b.has_value());
    if (!b) continue;
    ++hits;
    EXPECT_EQ(a->triangle, b->triangle) << i;
    EXPECT_EQ(a->t_mm, b->t_mm);
  }
  EXPECT_GT(hits, 1500);
}

// Rays through vertices, through edges, and a few float ulps beside them: where a float test would
// lose or mix up triangles.
TEST(ReferenceMeshTest, VerticesAndEdgesLoseNoRay) {
  const auto mesh = bumpy(3);
  const ReferenceMesh reference(mesh, 300.0);
  const Vector3d origin(3.0, -7.0, -270.0);
  RandomRays rays;
  for (std::size_t i = 0; i < mesh->triangles.size(); i += 2) {
    const auto& corners = mesh->triangles[i];
    const auto v = [&](int k) {
      return Vector3d(
          mesh->vertices_mm[static_cast<std::size_t>(corners[static_cast<std::size_t>(k)])].cast<double>());
    };
    const double f = rays.uniform(0, 1);
    for (const Vector3d& on : {Vector3d(v(0)), Vector3d(f * v(1) + (1 - f) * v(2))})
      for (double aside : {0.0, 1e-14, 1e-7, 1e-5}) {
        const Ray ray{origin, (on + aside * rays.direction() - origin).normalized()};
        const auto a = reference.nearest(ray, 0.0, far_mm),
                   b = reference.nearest_brute_force(ray, 0.0, far_mm);
        ASSERT_EQ(a.has_value(), b.has_value());
        if (!b) continue;
        EXPECT_EQ(a->triangle, b->triangle) << "triangle " << i << " aside " << aside;
        // nothing lies farther than the point aimed at, but for silhouettes a hair beside it
        const double limit_mm = aside == 0.0 ? (on - origin).norm() + 1e-9 : far_mm;
        EXPECT_LE(b->t_mm, limit_mm);
      }
  }
}

TEST(ReferenceMeshTest, TheSkippedTriangleDoesNotShade) {
  const ReferenceMesh reference(square(10), 300.0);
  const Ray down{{1, -3, -5}, Vector3d::UnitZ()};
  const auto hit = reference.nearest(down, 0.0, far_mm);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->t_mm, 5.0, 1e-12);
  EXPECT_TRUE(reference.occluded(down, 0.0, far_mm, -1));
  EXPECT_FALSE(reference.occluded(down, 0.0, far_mm, hit->triangle));
  EXPECT_FALSE(reference.occluded(down, 0.0, 4.9, -1));
  EXPECT_FALSE(reference.occluded(down, 5.1, far_mm, -1));
}

TEST(ReferenceMeshTest, ASquareOfTrianglesIsTheAnalyticRectangle) {
  PlaneShape plane = testing::frontal_plane(280.0);
  plane.size_mm = Vector2d(40.0, 40.0);
  const Twin rig = testing::crop_around(testing::paper_rig(), {0, 0, 280}, 420, 420);
  const Reference analytic(testing::with_object(rig, "plane", plane));
  const Reference meshed(testing::with_object(rig, "square", mesh_shape(square(20), {0, 0, 280})));
  const Reference smooth(testing::with_object(rig, "square", mesh_shape(square(20), {0, 0, 280}, true)));
  int hits = 0;
  for (double x = 0; x < 420; x += 11.3)
    for (double y = 0; y < 420; y += 12.7)
      for (std::size_t camera : {0u, 1u}) {
        const PixelSample a = analytic.sample(camera, {x, y}), b = meshed.sample(camera, {x, y});
        ASSERT_EQ(a.object, b.object);
        EXPECT_EQ(a.lit, b.lit);
        EXPECT_NEAR((a.point_world_mm - b.point_world_mm).norm(), 0.0, 1e-9);
        EXPECT_NEAR(a.weight, b.weight, 1e-12 * 11);
        EXPECT_NEAR(smooth.sample(camera, {x, y}).weight, a.weight, 1e-6 * 11);
        EXPECT_NEAR((a.projector_px - b.projector_px).norm(), 0.0, 1e-9);
        hits += a.object == 0;
      }
  EXPECT_GT(hits, 500);
}

// Vertices of an icosphere have the sphere's normals: smooth shading comes near the true sphere's
// light, facets do not.
TEST(ReferenceMeshTest, SmoothNormalsApproachTheSphere) {
  const auto mesh = std::make_shared<Mesh>(testing::make_bumpy_icosphere(4, 20.0, {}));
  const Twin rig = testing::crop_around(testing::paper_rig(), {0, 0, 270}, 200, 200);
  const Reference sphere(testing::with_object(rig, "s", SphereShape{{0, 0, 270}, 20.0}));
  const Reference facets(testing::with_object(rig, "s", mesh_shape(mesh, {0, 0, 270}, false)));
  const Reference smooth(testing::with_object(rig, "s", mesh_shape(mesh, {0, 0, 270}, true)));
  double facet_error = 0.0, smooth_error = 0.0;
  for (double x = 20; x < 180; x += 7.1)
    for (double y = 20; y < 180; y += 6.3) {
      const double truth = sphere.sample(0, {x, y}).weight;
      facet_error += std::abs(facets.sample(0, {x, y}).weight - truth);
      smooth_error += std::abs(smooth.sample(0, {x, y}).weight - truth);
    }
  EXPECT_LT(smooth_error, 0.1 * facet_error);
}

TEST(ReferenceMeshTest, VertexAlbedoIsAFactorOnDiffuse) {
  const auto mesh = square(40);
  auto painted = std::make_shared<Mesh>(*mesh);
  painted->vertex_albedo = {0.0f, 1.0f, 1.0f, 0.0f};  // = (x + 40)/80 on both triangles
  const Twin rig = testing::crop_around(testing::paper_rig(), {0, 0, 280}, 100, 100);
  const Reference plain(testing::with_object(rig, "square", mesh_shape(mesh, {0, 0, 280})));
  const Reference albedo(testing::with_object(rig, "square", mesh_shape(painted, {0, 0, 280})));
  for (double x = 1; x < 100; x += 9.7) {
    const PixelSample a = plain.sample(0, {x, 50}), b = albedo.sample(0, {x, 50});
    EXPECT_NEAR(b.weight, a.weight * (a.point_world_mm.x() + 40) / 80, 1e-12 * 11);
  }
}

TEST(ReferenceMeshTest, InstancesShareOneMeshAndShadeEachOther) {
  const auto mesh = bumpy(4, 10.0);
  Twin two = testing::crop_around(testing::paper_rig(), {0, 0, 270}, 500, 200);
  MeshShape left = mesh_shape(mesh, {-20, 0, 270}), right = mesh_shape(mesh, {22, 0, 265});
  right.T_world_object.rotation = rotation_from_vector({0.3, 1.2, -0.4});
  two.objects = {{"a", left, {}}, {"b", right, {}}};
  auto copy = std::make_shared<Mesh>(*mesh);  // the same shapes, no instance
  Twin copies = two;
  std::get<MeshShape>(copies.objects[1].shape).mesh = copy;
  const Reference a(two), b(copies);
  int seen[2] = {0, 0};
  for (double x = 0; x < 500; x += 5.3)
    for (double y = 0; y < 200; y += 6.1) {
      const PixelSample s = a.sample(0, {x, y}), t = b.sample(0, {x, y});
      ASSERT_EQ(s.object, t.object);
      EXPECT_EQ(s.triangle, t.triangle);
      EXPECT_EQ(s.weight, t.weight);
      if (s.object >= 0) ++seen[s.object];
    }
  EXPECT_GT(seen[0], 100);
  EXPECT_GT(seen[1], 100);
}

// A fine inscribed icosphere shades a plane like the sphere it approximates (sagitta 0.003 mm).
TEST(ReferenceMeshTest, CastsTheShadowOfItsShape) {
  const auto mesh = std::make_shared<Mesh>(testing::make_bumpy_icosphere(5, 5.0, {}));
  const Twin rig = testing::with_object(testing::crop_around(testing::paper_rig(), {10, 0, 300}, 500, 300),
                                        "plane", testing::frontal_plane());
  const Reference meshed(testing::with_object(rig, "ball", mesh_shape(mesh, {0, 0, 250})));
  const Reference sphere(testing::with_object(rig, "ball", testing::ideal_sphere()));
  int shaded = 0, different = 0, all = 0;
  for (double x = 0; x < 500; x += 2.3)
    for (double y = 0; y < 300; y += 2.9) {
      const PixelSample a = meshed.sample(0, {x, y}), b = sphere.sample(0, {x, y});
      if (a.object != 0 || b.object != 0) continue;
      ++all;
      shaded += !b.lit;
      different += a.lit != b.lit;
    }
  EXPECT_GT(shaded, 300);
  EXPECT_LE(different, all / 1000);
}

}  // namespace
}  // namespace fringetwin::render::reference_mesh_test
