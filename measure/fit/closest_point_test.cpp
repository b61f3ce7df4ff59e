// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-12 mm   tree against brute force: the same formula on the same doubles; ties at edges round
//   differently 1e-6 mm    analytic distances to meshes whose vertices are floats of size 1...10 (rounding
//   5e-7)
#include "measure/fit/closest_point.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#include "tests/support/measure/test_meshes.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure::closest_point_test {
namespace {

using namespace testing;

/// Distance to a segment or the triangle's inside, by a different route than the code under test: project to
/// the plane, barycentric test by areas, else the nearest of three segments.
double reference_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                          const Eigen::Vector3d& c) {
  const Eigen::Vector3d n = (b - a).cross(c - a).normalized();
  const Eigen::Vector3d q = p - n * n.dot(p - a);
  const auto left_of = [&](const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
    return (v - u).cross(q - u).dot(n) >= 0;
  };
  if (left_of(a, b) && left_of(b, c) && left_of(c, a)) return std::abs(n.dot(p - a));
  const auto segment = [&](const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
    const double t = std::clamp((p - u).dot(v - u) / (v - u).squaredNorm(), 0.0, 1.0);
    return (p - u - t * (v - u)).norm();
  };
  return std::min({segment(a, b), segment(b, c), segment(c, a)});
}

TEST(MeshDistance, AgreesWithBruteForce) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> u(-3, 3);
  const Mesh mesh = bumpy_sphere(10.0, 12);
  const MeshDistance tree(mesh);
  for (int k = 0; k < 300; ++k) {
    Eigen::Vector3d p(u(random), u(random), u(random));
    p *= k % 2 ? 1.0 : 4.0;
    double best = 1e9;
    for (const auto& t : mesh.triangles)
      best = std::min(best, reference_distance(p, mesh.vertices_mm[t[0]].cast<double>(),
                                               mesh.vertices_mm[t[1]].cast<double>(),
                                               mesh.vertices_mm[t[2]].cast<double>()));
    const ClosestPoint hit = tree.query(p);
    EXPECT_NEAR(std::abs(hit.signed_distance_mm), best, 1e-12);
    EXPECT_NEAR((p - hit.point_mm).norm(), best, 1e-12);
    // a limit below the distance finds nothing, one above finds the same
    EXPECT_EQ(tree.query(p, 0.99 * best).triangle, -1);
    EXPECT_EQ(tree.query(p, 1.01 * best).triangle, hit.triangle);
  }
}

TEST(MeshDistance, SurfaceNotVertices) {
  // two triangles, 100 mm wide: the nearest vertex is 50 mm away, the surface 0.25 mm
  const Mesh mesh = square(100.0f);
  const MeshDistance tree(mesh);
  const ClosestPoint above = tree.query({3, 7, 0.25}), below = tree.query({3, 7, -0.25});
  EXPECT_NEAR(above.signed_distance_mm, 0.25, 1e-12);
  EXPECT_NEAR(below.signed_distance_mm, -0.25, 1e-12);
  EXPECT_LT((above.point_mm - Eigen::Vector3d(3, 7, 0)).norm(), 1e-12);
  EXPECT_NEAR(tree.query({53, 54, 0}).signed_distance_mm, 5.0, 1e-12);  // beyond the corner
}

TEST(MeshDistance, SignIsRightAtEdgesAndCorners) {
  // beyond a sharp corner the plane of the nearest triangle alone may claim "inside"
  const Mesh mesh = box(2.0f);
  const MeshDistance tree(mesh);
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> u(-2, 2);
  for (int k = 0; k < 5000; ++k) {
    const Eigen::Vector3d p(u(random), u(random), u(random));
    const Eigen::Vector3d outside = (p.cwiseAbs().array() - 1.0).max(0.0);
    const double expected = outside.norm() > 0.0 ? outside.norm() : p.cwiseAbs().maxCoeff() - 1.0;
    EXPECT_NEAR(tree.query(p).signed_distance_mm, expected, 1e-12);
  }
  EXPECT_NEAR(tree.query({2, 2, 2}).signed_distance_mm, std::sqrt(3.0), 1e-12);
}

TEST(MeshDistance, DegenerateTrianglesAreSkippedAndEmptyMeshesRefused) {
  Mesh mesh = square(10.0f);
  mesh.triangles.push_back({0, 0, 1});
  EXPECT_NEAR(MeshDistance(mesh).query({0, 0, 1}).signed_distance_mm, 1.0, 1e-12);
  EXPECT_THROW(MeshDistance(Mesh{}), UserError);
}

TEST(MeshDistance, OneTreePerMesh) {
  auto mesh = std::make_shared<const Mesh>(bumpy_sphere(10.0, 100));
  const auto a = mesh_distance_for(mesh);
  EXPECT_EQ(a, mesh_distance_for(mesh));
  EXPECT_NE(a, mesh_distance_for(std::make_shared<const Mesh>(square(1.0f))));
  const auto start = std::chrono::steady_clock::now();
  std::mt19937_64 random(3);
  std::normal_distribution<double> n;
  const int queries = 100000;
  for (int k = 0; k < queries; ++k)
    a->query(Eigen::Vector3d(n(random), n(random), n(random)).normalized() * 10.3, 2.0);
  std::printf(
      "%zu triangles: %.2f us a query\n", mesh->triangles.size(),
      1e6 / queries * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace
}  // namespace fringetwin::measure::closest_point_test
