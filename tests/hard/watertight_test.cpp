// SPDX-License-Identifier: Apache-2.0
// No light and no ray slips between triangles that share an edge or a vertex. A sheet covers the view:
// every ray that misses it is a leak, counted exactly (hit fraction, a multiple of 1/256).
// | tolerance | unit  | origin                                                                       |
// |-----------|-------|------------------------------------------------------------------------------|
// | 0         | leaks | required; random rays, rays aimed at vertices and edges, shadow rays           |
// The program `hard_slow_tests` (label slow) is the same file with 1e8 random rays.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/hard_support.hpp"

namespace fringetwin::testing::watertight_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

#ifdef FRINGETWIN_1E8_RAYS
constexpr int random_samples = 512, random_side = 448;  // 1.03e8 rays
#else
constexpr int random_samples = 64, random_side = 320;  // 6.6e6 rays
#endif

/// Everything hit gets 1, nothing else does: the projector looks away.
Twin ambient_only(int side) {
  Twin twin = bench_rig(1000.0, side, side);
  twin.projector->T_proj_world.rotation = rotation_from_vector({3.1, 0.0, 0.0});
  twin.projector->ambient = 1.0;
  twin.fringes.directions[0].pitches_px = {13.0};
  twin.fringes.directions[0].phase_origin_px = {0.0};
  return twin;
}

std::int64_t leaks(const Twin& twin, const render::Sampling& sampling, std::uint64_t seed = 0) {
  const auto t = shared_renderer()->trace(twin, 0, sampling, seed);
  std::int64_t n = 0;
  for (const float hit : t.ambient.data) n += std::lround((1.0 - hit) * sampling.samples);
  return n;
}

Mesh bumpy_sheet(int cells) {
  const auto bumps = [](double x, double y) {
    return 6.0 * std::sin(0.31 * x) * std::cos(0.27 * y) + 0.8 * std::sin(2.3 * x + 1.7 * y);
  };
  const double step = 220.0 / cells;  // wider than the view
  return height_field(-110, -110, step, step, cells, cells, bumps);
}

TEST(Watertight, RandomRays) {
  REQUIRE_RENDERER();
  const Pose T = {rotation_from_vector({0.21, -0.13, 0.4}), {0, 0, 280}};
  const Twin twin = with_object(ambient_only(random_side), "sheet", as_shape(bumpy_sheet(200), T));
  const std::int64_t n = leaks(twin, {Sampler::multi_jittered, random_samples}, 4);
  report(fmt::format("{:.2e} random rays on 80,000 triangles", std::pow(random_side, 2) * random_samples), "",
         fmt::format("{} leaks", n));
  EXPECT_EQ(n, 0);
}

#ifndef FRINGETWIN_1E8_RAYS

struct Aim {
  const char* name;
  Eigen::Vector2d offset_px;
};
const Aim aims[] = {{"vertices", {0, 0}}, {"edges", {0.5, 0}}, {"diagonals", {0.5, 0.5}}};

// One ray through every pixel's centre, and there lies a vertex or an edge of the sheet: as it comes,
// turned by four random rotations, seen edge-on in places.
TEST(Watertight, RaysAimedAtVerticesAndEdges) {
  REQUIRE_RENDERER();
  Twin rig = ambient_only(320);
  rig.render.pixel_fill = 0.0;
  for (const Aim& aim : aims) {
    std::int64_t n = 0;
    int rays = 0;
    for (unsigned seed = 0; seed < 5; ++seed) {
      Pose T = random_pose(seed, {1.0, 2.0, 290.0});
      if (seed == 0) T = {};
      const double bump = seed % 2 ? 3.0 : 0.0;
      const Twin twin = with_object(
          rig, "sheet", as_shape(aimed_sheet(rig.cameras[0].lens, aim.offset_px, 256.0, bump, T), T));
      n += leaks(twin, {Sampler::gauss, 1});
      rays += 320 * 320;
    }
    report(fmt::format("{} rays aimed at {}", rays, aim.name), "", fmt::format("{} leaks", n));
    EXPECT_EQ(n, 0) << aim.name;
  }
}

// A sheet between projector and wall: every shadow ray must be stopped.
TEST(Watertight, ShadowRays) {
  REQUIRE_RENDERER();
  Twin twin = bench_rig(1000.0, 320, 320, 150.0);
  twin.projector->T_proj_world.rotation = rotation_from_vector({0.0, 0.42, 0.0});
  twin.projector->T_proj_world.translation_mm =
      -(twin.projector->T_proj_world.rotation * Vector3d(150, 0, 0));
  twin = with_object(twin, "wall", frontal_plane(300.0));
  const auto lit = shared_renderer()->trace(twin, 0, {Sampler::multi_jittered, 16}, 2);
  // 12 x 9 cm at 60 mm before the projector: the projected light passes 45 x 26 mm of it
  const Pose T = {rotation_from_vector({0.05, -0.42, 0.3}), {125.0, 0.0, 55.0}};
  const auto bumps = [](double x, double y) { return 0.3 * std::sin(1.3 * x) * std::cos(0.9 * y); };
  const Twin dark =
      with_object(twin, "sheet", as_shape(height_field(-60, -45, 0.5, 0.5, 240, 180, bumps), T));
  const auto t = shared_renderer()->trace(dark, 0, {Sampler::multi_jittered, 16}, 2);
  std::int64_t seen = 0, bright = 0;
  for (std::size_t i = 0; i < t.mean.size(); ++i)
    if (t.object.data[i] == 0 && lit.mean.data[i] > 0.0F) {
      ++seen;
      bright += t.mean.data[i] > 0.0F;
    }
  report(fmt::format("{} shadow rays through a sheet of 86,400 triangles", 16 * seen), "",
         fmt::format("{} pixels lit", bright));
  EXPECT_GT(seen, 50'000);
  EXPECT_EQ(bright, 0);
}

// The two tests in the same single precision on the CPU: rays towards the vertices (and points of the
// edges) of a turned sheet, against all triangles around.
struct CpuLeaks {
  int moeller_trumbore = 0, pluecker = 0, projected = 0, rays = 0;
};
CpuLeaks cpu_leaks(bool edges) {
  constexpr int n = 240;
  CpuLeaks out;
  std::mt19937 random(9);
  std::uniform_real_distribution<float> u(0.0F, 1.0F);
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Pose T = random_pose(seed, {1.0, 2.0, 290.0});
    const Mesh mesh =
        aimed_sheet(Lens("LENSMODEL_PINHOLE", {1000, 1000, n / 2, n / 2}, {n, n}, ""), {0, 0}, 256.0, 3.0, T);
    const int columns = n + 6;
    const Vector3f o = T.inverse().translation_mm.cast<float>();
    const auto vertex = [&](int i, int j) {
      return mesh.vertices_mm[static_cast<std::size_t>(j * columns + i)];
    };
    for (int j = 2; j < n + 2; ++j)
      for (int i = 2; i < n + 2; ++i) {
        Vector3f target = vertex(i, j);
        if (edges) target += u(random) * (vertex(i + 1, j) - vertex(i, j));
        const Vector3f d = target - o;
        bool mt = false, pluecker = false, projected = false;
        for (int b = j - 2; b < j + 2; ++b)
          for (int a = i - 2; a < i + 2; ++a) {
            const Vector3f v00 = vertex(a, b), v10 = vertex(a + 1, b), v01 = vertex(a, b + 1),
                           v11 = vertex(a + 1, b + 1);
            mt = mt || moeller_trumbore(o, d, v00, v10, v01) || moeller_trumbore(o, d, v10, v11, v01);
            pluecker = pluecker || pluecker_edges(o, d, v00, v10, v01) || pluecker_edges(o, d, v10, v11, v01);
            projected =
                projected || projected_edges(o, d, v00, v10, v01) || projected_edges(o, d, v10, v11, v01);
          }
        out.moeller_trumbore += !mt;
        out.pluecker += !pluecker;
        out.projected += !projected;
        ++out.rays;
      }
  }
  return out;
}

TEST(Watertight, SchoolbookLeaks) {
  for (const bool edges : {false, true}) {
    const CpuLeaks n = cpu_leaks(edges);
    report(fmt::format("{} rays aimed at {} on the CPU", n.rays, edges ? "edges" : "vertices"),
           fmt::format("Moeller-Trumbore {} leaks, edges in space {}", n.moeller_trumbore, n.pluecker),
           fmt::format("{} leaks", n.projected));
    EXPECT_GT(n.moeller_trumbore, 0);
    EXPECT_EQ(n.projected, 0);
  }
}

#endif

}  // namespace
}  // namespace fringetwin::testing::watertight_test
