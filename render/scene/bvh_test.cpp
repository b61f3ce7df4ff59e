// SPDX-License-Identifier: Apache-2.0
// No tolerances: boxes must contain their triangles exactly, every triangle must be found once.
#include "render/scene/bvh.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <random>

#include "tests/support/freeform.hpp"

namespace fringetwin::render::bvh_test {
namespace {

struct Soup {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<int, 3>> triangles;
  void add(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
    const int n = static_cast<int>(vertices.size());
    vertices.insert(vertices.end(), {a, b, c});
    triangles.push_back({n, n + 1, n + 2});
  }
};

class Checker {
 public:
  Checker(const Bvh& bvh, const Soup& soup) : bvh_(bvh), soup_(soup), seen_(soup.triangles.size(), 0) {
    visit(0, 1);
    EXPECT_TRUE(std::all_of(seen_.begin(), seen_.end(), [](int n) { return n == 1; }));
    EXPECT_EQ(deepest_, bvh.depth);
  }

 private:
  void visit(int index, int depth) {
    deepest_ = std::max(deepest_, depth);
    const BvhNode& n = bvh_.nodes[static_cast<std::size_t>(index)];
    child(n.left, n.left_min, n.left_max, depth);
    if (n.right_min.x() <= n.right_max.x()) child(n.right, n.right_min, n.right_max, depth);
  }
  void child(int c, const Eigen::Vector3f& lo, const Eigen::Vector3f& hi, int depth) {
    if (c >= 0) {
      visit(c, depth + 1);
      return;
    }
    const int first = ~c / 8, count = ~c % 8 + 1;
    EXPECT_LE(count, 4);
    for (int i = first; i < first + count; ++i) {
      const std::uint32_t t = bvh_.order[static_cast<std::size_t>(i)];
      ++seen_[t];
      for (const int v : soup_.triangles[t]) {
        const Eigen::Vector3f& p = soup_.vertices[static_cast<std::size_t>(v)];
        EXPECT_TRUE((p.array() >= lo.array()).all() && (p.array() <= hi.array()).all());
      }
    }
  }
  const Bvh& bvh_;
  const Soup& soup_;
  std::vector<int> seen_;
  int deepest_ = 0;
};

Bvh build(const Soup& soup, int max_depth = 32) {
  return build_bvh(soup.vertices, soup.triangles, max_depth);
}

Soup random_soup(int n, float spread) {
  Soup soup;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> u(-1.0F, 1.0F);
  const auto point = [&] { return Eigen::Vector3f(u(random), u(random), u(random)); };
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3f c = spread * point();
    soup.add(c + point(), c + point(), c + point());
  }
  return soup;
}

TEST(Bvh, FewTriangles) {
  for (int n = 1; n <= 9; ++n) Checker(build(random_soup(n, 5.0F)), random_soup(n, 5.0F));
}

TEST(Bvh, RandomSoup) {
  const Soup soup = random_soup(5000, 30.0F);
  Checker(build(soup), soup);
}

// All centroids in one point: no plane separates them.
TEST(Bvh, CoincidentTriangles) {
  Soup soup;
  for (int i = 0; i < 1000; ++i) soup.add({-1, -1, 0}, {1, -1, 0}, {0, 2, 0});
  const Bvh bvh = build(soup);
  Checker(bvh, soup);
  EXPECT_LE(bvh.depth, 10);
}

// Sizes in a geometric series tempt the heuristic into a list; the stack of the shader must suffice.
TEST(Bvh, DepthIsBounded) {
  Soup soup;
  float x = 1.0F;
  for (int i = 0; i < 3000; ++i) {
    soup.add({x, 0, 0}, {x * 1.01F, 0, 0}, {x, x * 0.01F, 0});
    x *= 1.02F;
  }
  for (const int limit : {12, 16, 32}) {
    const Bvh bvh = build(soup, limit);
    Checker(bvh, soup);
    EXPECT_LE(bvh.depth, limit);
  }
}

TEST(Bvh, FlatGridWithoutThickness) {
  Soup soup;
  for (int j = 0; j < 30; ++j)
    for (int i = 0; i < 30; ++i) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      soup.add({x, y, 0}, {x + 1, y, 0}, {x, y + 1, 0});
    }
  Checker(build(soup), soup);
}

// An extent so small that 16 bins over it overflow: a flat part with one vertex a denormal off its plane.
TEST(Bvh, DenormalExtents) {
  Soup soup;
  for (int i = 0; i < 6; ++i) {
    const auto x = static_cast<float>(i);
    soup.add({x, 0, 0}, {x + 1, 0, 0}, {x, 1, i == 3 ? 1e-40F : 0.0F});
  }
  Checker(build(soup), soup);
  Soup speck;  // nothing but denormals
  for (int i = 0; i < 6; ++i) {
    const float x = 1e-40F * static_cast<float>(i);
    speck.add({x, 0, 0}, {x, 1e-41F, 0}, {x, 0, 1e-42F});
  }
  Checker(build(speck), speck);
}

TEST(Bvh, SameForAnyNumberOfThreads) {
  const Mesh mesh = testing::make_bumpy_icosphere(6, 35.0, testing::default_bumps());
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const Bvh one = build_bvh(mesh.vertices_mm, mesh.triangles, 32);
  omp_set_num_threads(4);
  const auto start = std::chrono::steady_clock::now();
  const Bvh four = build_bvh(mesh.vertices_mm, mesh.triangles, 32);
  const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
  omp_set_num_threads(threads);
  std::cout << mesh.triangles.size() << " triangles: depth " << four.depth << ", " << four.nodes.size()
            << " nodes, " << ms.count() << " ms\n";
  ASSERT_EQ(one.nodes.size(), four.nodes.size());
  EXPECT_EQ(one.order, four.order);
  EXPECT_EQ(std::memcmp(one.nodes.data(), four.nodes.data(), one.nodes.size() * sizeof(BvhNode)), 0);
}

}  // namespace
}  // namespace fringetwin::render::bvh_test
