// SPDX-License-Identifier: Apache-2.0
// What hides what in a mesh, against all pairs of triangles in double precision.
// | tolerance | unit      | origin                                                                        |
// |-----------|-----------|-------------------------------------------------------------------------------|
// | 0         | triangles | a triangle called clear has no other one between it and the eye                |
// | 0.9       | share     | of what random segments find unhidden, so that the answer is of use           |
#include "render/scene/visibility.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/freeform.hpp"

namespace fringetwin::render::visibility_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Does the open segment from a to b meet the triangle's inside? Signs of volumes: no division.
bool meets(const Vector3d& a, const Vector3d& b, const std::array<Vector3d, 3>& t) {
  const auto volume = [](const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& s) {
    return (q - p).cross(r - p).dot(s - p);
  };
  const double at_a = volume(t[0], t[1], t[2], a), at_b = volume(t[0], t[1], t[2], b);
  if (!(at_a * at_b < 0.0)) return false;
  const double e0 = volume(a, b, t[0], t[1]), e1 = volume(a, b, t[1], t[2]), e2 = volume(a, b, t[2], t[0]);
  return (e0 > 0.0 && e1 > 0.0 && e2 > 0.0) || (e0 < 0.0 && e1 < 0.0 && e2 < 0.0);
}

struct Count {
  int clear = 0, free = 0, wrong = 0;
};

Count check(const Mesh& mesh, const Vector3d& eye) {
  const auto clear = clear_from(eye, mesh.vertices_mm, mesh.triangles);
  std::vector<std::array<Vector3d, 3>> corners;
  for (const auto& t : mesh.triangles)
    corners.push_back({mesh.vertices_mm[static_cast<std::size_t>(t[0])].cast<double>(),
                       mesh.vertices_mm[static_cast<std::size_t>(t[1])].cast<double>(),
                       mesh.vertices_mm[static_cast<std::size_t>(t[2])].cast<double>()});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(0.01, 1.0);
  Count count;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    bool hidden = false;
    for (int k = 0; k < 4; ++k) {
      const double a = u(random), b = u(random), c = u(random), sum = a + b + c;
      const Vector3d p = (a * corners[i][0] + b * corners[i][1] + c * corners[i][2]) / sum;
      const Vector3d short_of_it = eye + (1.0 - 1e-7) * (p - eye);
      for (std::size_t j = 0; j < corners.size() && !hidden; ++j)
        hidden = j != i && meets(eye, short_of_it, corners[j]);
    }
    count.clear += clear[i];
    count.free += !hidden;
    count.wrong += clear[i] && hidden;
  }
  return count;
}

TEST(Visibility, ClosedPart) {
  const Mesh mesh = testing::make_bumpy_icosphere(3, 35.0, testing::default_bumps());
  for (const Vector3d& eye : {Vector3d(0, 0, -270), Vector3d(190, 0, -250), Vector3d(0, 60, 1e5)}) {
    const Count n = check(mesh, eye);
    EXPECT_EQ(n.wrong, 0);
    EXPECT_GE(n.clear, 0.9 * n.free);
    EXPECT_LE(n.free, 0.6 * static_cast<double>(mesh.triangles.size()));
  }
}

// A wide dent close to the eye, so that parts hide others.
TEST(Visibility, FoldsHideWhatIsBehind) {
  Mesh mesh;
  constexpr int n = 40;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.vertices_mm.emplace_back(static_cast<float>(i - n / 2), static_cast<float>(j - n / 2),
                                    static_cast<float>(5.0 * std::sin(0.7 * i) + 3.0 * std::cos(0.5 * j)));
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {b, d, c}});
    }
  const Count count = check(mesh, {-60, 0, -25});
  EXPECT_EQ(count.wrong, 0);
  EXPECT_GE(count.clear,
            0.75 * count.free);  // at borders triangles are hidden in part: a few points miss that
  EXPECT_LT(count.free, static_cast<int>(mesh.triangles.size()) * 3 / 4);
  EXPECT_FALSE(make_adjacency(mesh.triangles, mesh.vertices_mm.size()).closed);
}

TEST(Visibility, SoupOfTriangles) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(-10.0F, 10.0F), small(-2.0F, 2.0F);
  Mesh mesh;
  for (int i = 0; i < 700; ++i) {
    const Vector3f p(u(random), u(random), u(random));
    for (int k = 0; k < 3; ++k)
      mesh.vertices_mm.push_back(p + Vector3f(small(random), small(random), small(random)));
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const Count n = check(mesh, {3, -2, -40});
  EXPECT_EQ(n.wrong, 0);
  EXPECT_GT(n.clear, 20);
  const Adjacency adjacency = make_adjacency(mesh.triangles, mesh.vertices_mm.size());
  for (const auto& neighbours : adjacency.neighbours)
    for (const std::int32_t neighbour : neighbours) EXPECT_EQ(neighbour, -1);
}

TEST(Visibility, NothingIsClearFromInside) {
  const Mesh mesh = testing::make_bumpy_icosphere(2, 35.0, {});
  for (const auto c : clear_from({1, 2, 3}, mesh.vertices_mm, mesh.triangles)) EXPECT_EQ(c, 0);
}

TEST(Visibility, NeighboursShareTheSideOppositeTheCorner) {
  const Mesh mesh = testing::make_bumpy_icosphere(3, 35.0, testing::default_bumps());
  const Adjacency adjacency = make_adjacency(mesh.triangles, mesh.vertices_mm.size());
  EXPECT_TRUE(adjacency.closed);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& other = mesh.triangles[static_cast<std::size_t>(adjacency.neighbours[i][k])];
      for (const std::size_t end : {(k + 1) % 3, (k + 2) % 3})
        EXPECT_NE(std::find(other.begin(), other.end(), mesh.triangles[i][end]), other.end());
      EXPECT_EQ(std::find(other.begin(), other.end(), mesh.triangles[i][k]), other.end());
    }
  auto turned = mesh.triangles;
  std::swap(turned[5][0], turned[5][1]);
  EXPECT_FALSE(make_adjacency(turned, mesh.vertices_mm.size()).closed);
}

}  // namespace
}  // namespace fringetwin::render::visibility_test
