// SPDX-License-Identifier: Apache-2.0
// Light that comes over any number of surfaces ([render] bounces = N and "all").
// | tolerance     | of                | origin                                                           |
// |---------------|-------------------|------------------------------------------------------------------|
// | 0.3 %, 1 %    | the indirect light| mean and rms over pixels, closed radiosity of a groove            |
// | 0.5 %, 3 %    | the same          | a cavity: its facets (0.1 % of a radius), 1,024 directions        |
// | 1e-3 rad rms  | phase             | a groove under fringes against paths at random, 16,384 directions |
// | 0.3 %, 0.5 %  | the indirect light| mean over a wall behind a ball, over more surfaces and over one    |
// | 0.1 %         | full scale rms    | its gray values, the same                                        |
// | 4.5e-3, 0.3 % | the same          | 256 directions: 8 times the noise, for 64^(3/4) = 23 at most      |
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <iostream>
#include <memory>
#include <numbers>
#include <tuple>

#include "render/base/quadrature.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/groove.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/mesh/mesh.hpp"

namespace fringetwin::testing::bounces_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;
/// What a twin shows besides its direct light: mean over all patterns, per pixel.
ImageF indirect_mean(Twin twin, const render::Sampling& sampling) {
  const auto all = shared_renderer()->trace(twin, 0, sampling);
  twin.render.bounces = 0;
  const auto direct = shared_renderer()->trace(twin, 0, sampling);
  ImageF out = all.mean;
  for (std::size_t i = 0; i < out.size(); ++i) out.data[i] -= direct.mean.data[i];
  return out;
}

/// Radiosity of the two walls of an endless groove by their light `direct(side, distance from the apex)`:
/// B_i(x) = D_i(x) + rho int K(x, y) B_k(y) dy, K = x y/2 (x^2 + y^2)^(-3/2), by Gauss's rule on panels that
/// become smaller towards the apex (Nystrom's method).
class GrooveRadiosity {
 public:
  template <class Direct>
  GrooveRadiosity(double rho, int bounces, const Direct& direct) : rho_(rho) {
    const auto& rule = render::gauss_rule(8);
    double end = kWallMm;
    for (int panel = 0; panel < 14; ++panel) {
      const double begin = panel < 13 ? 0.5 * end : 0.0;
      for (std::size_t k = 0; k < 8; ++k) {
        x_.push_back(0.5 * (begin + end) + 0.5 * (end - begin) * rule.nodes[k]);
        weight_.push_back(0.5 * (end - begin) * rule.weights[k]);
      }
      end = begin;
    }
    const auto n = static_cast<Eigen::Index>(x_.size());
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    Eigen::VectorXd b(2 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
      b[i] = direct(0, x_[i]);
      b[n + i] = direct(1, x_[i]);
      for (Eigen::Index k = 0; k < n; ++k)
        K(i, n + k) = K(n + i, k) = rho * kernel(x_[i], x_[k]) * weight_[k];
    }
    light_ = b;
    for (int k = 1; k < std::min(bounces, 200); ++k) light_ = b + K * light_;
  }
  /// Returns what reaches a place over other surfaces, as radiosity.
  double indirect(int side, double x) const {
    const auto n = static_cast<Eigen::Index>(x_.size());
    double sum = 0.0;
    for (Eigen::Index k = 0; k < n; ++k) sum += kernel(x, x_[k]) * weight_[k] * light_[(1 - side) * n + k];
    return rho_ * sum;
  }

 private:
  static double kernel(double x, double y) { return 0.5 * x * y / std::pow(x * x + y * y, 1.5); }
  double rho_;
  std::vector<double> x_, weight_;
  Eigen::VectorXd light_;
};

TEST(AllBounces, OfAnEndlessGrooveAreItsRadiosity) {
  REQUIRE_RENDERER();
  constexpr double kRho = 0.8;
  Twin twin = groove(kRho, 4000.0);
  // from so far away that the light is the same along the groove and on each wall
  const Vector3d from = Vector3d(0.25, 0.0, -1.0).normalized() * 1e5;
  Pose& T = twin.projector->T_proj_world;
  T.rotation.row(2) = -from.normalized().transpose();
  T.rotation.row(0) = Vector3d(0, 1, 0).cross(-from).normalized().transpose();
  T.rotation.row(1) = T.rotation.row(2).cross(T.rotation.row(0));
  T.translation_mm = -T.rotation * (Vector3d(0, 0, kApexMm) + from);
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {1.2e4, 1.2e4, 320, 240}, {640, 480}, "from afar");
  twin.fringes.directions = {{Axis::x, {640.0}, {0.0}, {}}};
  const render::Reference reference(twin);
  const auto on_wall = [&](int side) {
    return twin.projector->intensity * kRho / pi *
           Vector3d(side == 0 ? 1 : -1, 0, -1).normalized().dot(from.normalized());
  };
  for (const int bounces : {1, 2, 3, kAllBounces}) {
    twin.render.bounces = bounces;
    twin.render.bounce_samples = 4096;
    const ImageF found = indirect_mean(twin, {Sampler::gauss, 4});
    const GrooveRadiosity truth(kRho, bounces, [&](int side, double) { return on_wall(side); });
    Errors errors;
    double share = 0.0;
    for (int y = 30; y < 90; y += 3)
      for (int x = 20; x < 140; x += 2) {
        const auto s = reference.sample(0, {static_cast<double>(x), static_cast<double>(y)});
        if (!s.lit || !reference.is_whole(0, x, y)) continue;
        const double distance = (s.point_world_mm - Vector3d(0, s.point_world_mm.y(), kApexMm)).norm();
        if (distance > kWallMm - 1.0) continue;
        const double expected = truth.indirect(s.object, distance);
        share = std::max(share, expected / on_wall(s.object));
        errors.add(static_cast<double>(found(x, y)) / expected - 1.0);
      }
    std::cout << "endless groove, bounces " << bounces << ": " << errors.n << " pixels, mean error "
              << errors.mean() << ", rms " << errors.rms() << ", up to " << share << " of the direct light\n";
    EXPECT_GT(errors.n, 300);
    EXPECT_GT(share, bounces == 1 ? 0.3 : 0.5);
    EXPECT_LE(std::abs(errors.mean()), 0.003);
    EXPECT_LE(errors.rms(), 0.01);
  }
}

TEST(AllBounces, UnderFringesAgreeWithPathsAtRandom) {
  REQUIRE_RENDERER();
  const Twin dark = groove(0.8);
  const render::Sampling sampling{Sampler::gauss, 16};
  const auto direct = shared_renderer()->trace(dark, 0, sampling);
  for (const int bounces : {1, 2, kAllBounces}) {
    Twin twin = dark;
    twin.render.bounces = bounces;
    const auto truth = reference_block(render::Reference(twin), 0, {20, 20, 120, 80, 17},
                                       {.gauss_n = 2, .bounce_n = 128, .paths = 4});
    const Differences without = differences(twin, direct, truth);
    for (const auto& [directions, phase_rad, gray] :
         {std::tuple{256, 4.5e-3, 3e-3}, std::tuple{16384, 1e-3, 1e-3}}) {
      twin.render.bounce_samples = directions;
      const Differences d = differences(twin, shared_renderer()->trace(twin, 0, sampling), truth);
      std::cout << "groove, bounces " << bounces << ", " << directions << " directions: " << d.gray.n
                << " pixels, phase " << d.phase_rad.rms() << " rad rms (without " << without.phase_rad.rms()
                << "), gray " << d.gray.rms() << " of full scale (without " << without.gray.rms() << ")\n";
      EXPECT_GT(d.gray.n, 25);
      EXPECT_GT(without.phase_rad.rms(), 5e-3);
      EXPECT_GT(without.gray.rms(), 0.02);
      EXPECT_LE(d.phase_rad.rms(), phase_rad);
      EXPECT_LE(d.gray.rms(), gray);
    }
  }
}

// Behind a ball, a wall gets most of what has come over two surfaces from the ball's back, whose light falls
// off within millimetres of the gap: the hardest case for cells of light.
TEST(AllBounces, OverTheBackOfABallReachTheWallBehindIt) {
  REQUIRE_RENDERER();
  Twin twin = rig_before(300.0);
  twin = with_object(twin, "ball", SphereShape{.center_mm = {2.0, -1.0, 290.0}, .radius_mm = 19.0},
                     {0.7, 0.0, 10.0});
  twin = with_object(twin, "wall",
                     PlaneShape{.point_mm = {0, 0, 314},
                                .normal = Vector3d(0.05, -0.08, -1).normalized(),
                                .size_mm = {},
                                .u_axis = {1, 0, 0}},
                     {0.5, 0.0, 10.0});
  twin.fringes.directions[0] = {Axis::x, {640.0}, {0.0}, {}};
  twin.render.bounce_samples = 4096;
  const auto light = [&](int bounces) {
    twin.render.bounces = bounces;
    return std::pair{shared_renderer()->trace(twin, 0, {Sampler::gauss, 4}).mean,
                     reference_block(render::Reference(twin), 0, {2, 2, 158, 118, 13},
                                     {.gauss_n = 1, .bounce_n = bounces > 0 ? 128 : 1, .paths = 16})};
  };
  const render::Reference reference(twin);
  const auto [found_direct, direct] = light(0);
  const auto [found_one, one] = light(1);
  const auto [found_all, all] = light(kAllBounces);
  double found = 0.0, expected = 0.0, found_first = 0.0, expected_first = 0.0;
  int n = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& p = all[i];
    if (!p.interior || reference.sample(0, Vector2d(p.x, p.y)).object != 1) continue;
    ++n;
    found += static_cast<double>(found_all(p.x, p.y) - found_one(p.x, p.y));
    expected += p.pixel.mean - one[i].pixel.mean;
    found_first += static_cast<double>(found_one(p.x, p.y) - found_direct(p.x, p.y));
    expected_first += one[i].pixel.mean - direct[i].pixel.mean;
  }
  std::cout << "wall behind a ball: " << n << " pixels, over one surface " << found_first / expected_first
            << " of the truth, over more " << found / expected << " (" << expected / expected_first
            << " of the first)\n";
  EXPECT_GT(n, 40);
  EXPECT_NEAR(found_first / expected_first, 1.0, 0.005);  // 1/24 of the other: few of the truth's directions
  EXPECT_NEAR(found / expected, 1.0, 0.003);
}

/// A sphere of triangles, open for polar angles of the camera's side beyond 150 degrees.
Mesh cavity(double radius_mm, const Vector3d& center_mm) {
  constexpr int kRings = 60, kClosed = 50, kSpokes = 120;
  Mesh mesh;
  for (int i = 0; i <= kClosed; ++i)
    for (int k = 0; k < kSpokes; ++k) {
      const double polar = pi * i / kRings, angle = 2.0 * pi * k / kSpokes;
      mesh.vertices_mm.push_back(
          (center_mm + radius_mm * Vector3d(std::sin(polar) * std::cos(angle),
                                            std::sin(polar) * std::sin(angle), std::cos(polar)))
              .cast<float>());
    }
  for (int i = 0; i < kClosed; ++i)
    for (int k = 0; k < kSpokes; ++k) {
      const int a = i * kSpokes + k, b = i * kSpokes + (k + 1) % kSpokes;
      if (i > 0) mesh.triangles.push_back({a, b, a + kSpokes});
      mesh.triangles.push_back({b, b + kSpokes, a + kSpokes});
    }
  return mesh;
}

// In a spherical cavity every place gets the same of every other: light D(q) that the walls send of the
// projector's alone is followed by rho/(1 - rho (1 - open)) of its mean over the whole sphere, everywhere.
TEST(AllBounces, OfASphericalCavityAreTheSameEverywhere) {
  REQUIRE_RENDERER();
  constexpr double kRho = 0.7, kRadiusMm = 150.0;
  const double open = 0.5 * (1.0 - std::cos(pi / 6.0));  // share of the sphere
  const Vector3d center(0.0, 0.0, 10.0 + kRadiusMm * std::cos(pi / 6.0));
  Twin twin = rig_before(200.0);
  MeshShape shape;
  shape.mesh = std::make_shared<const Mesh>(cavity(kRadiusMm, center));
  twin = with_object(twin, "cavity", shape, {kRho, 0.0, 10.0});
  twin.render.bounces = kAllBounces;
  twin.render.bounce_samples = 1024;
  const ImageF found = indirect_mean(twin, {Sampler::gauss, 1});
  // the mean over the sphere by rays of the projector: the walls' light times the area that a pixel lights
  const Lens& lens = twin.projector->lens;
  const Pose T_world_proj = twin.projector->T_proj_world.inverse();
  const Vector3d from = T_world_proj.translation_mm;
  double flux = 0.0;
  for (int y = 0; y < lens.height(); ++y)
    for (int x = 0; x < lens.width(); ++x) {
      const Vector3d ray((x - 320.0) / 900.0, (y - 240.0) / 900.0, 1.0);
      const Vector3d d = (T_world_proj.rotation * ray).normalized(), to = from - center;
      const double b = d.dot(to), t = -b + std::sqrt(b * b - to.squaredNorm() + kRadiusMm * kRadiusMm);
      // light per area kRho/pi I cos; area t^2 omega/cos: the cosine cancels
      flux += kRho / pi * twin.projector->intensity * t * t / (900.0 * 900.0 * std::pow(ray.norm(), 3));
    }
  const double expected = kRho / (1.0 - kRho * (1.0 - open)) * flux / (4.0 * pi * kRadiusMm * kRadiusMm);
  Errors errors;
  for (int y = 4; y < 120; y += 8)
    for (int x = 4; x < 160; x += 8) errors.add(static_cast<double>(found(x, y)) / expected - 1.0);
  std::cout << "cavity: expected " << expected << ", mean error " << errors.mean() << ", rms " << errors.rms()
            << '\n';
  EXPECT_LE(std::abs(errors.mean()), 0.005);
  EXPECT_LE(errors.rms(), 0.03);
}

// More sums than one pass holds, and passes of different sizes: each pass has light of its own.
TEST(AllBounces, OfManyImagesAreThoseOfFew) {
  REQUIRE_RENDERER();
  for (const int bounces : {1, kAllBounces}) {
    Twin few = groove(0.8);
    few.fringes.directions = {{Axis::x, {12.0}, {0.0}, GrayCode{.bits = 6, .complementary = true}}};
    few.fringes.unwrap = Unwrap::gray;
    few.render.bounces = bounces;
    few.render.bounce_samples = 1024;
    Twin many = few;
    many.fringes.directions.push_back({Axis::y, {12.0}, {0.0}, GrayCode{.bits = 7, .complementary = true}});
    many.fringes.directions.push_back({Axis::y, {20.0}, {0.0}, GrayCode{.bits = 6, .complementary = true}});
    const render::Sampling sampling{Sampler::gauss, 4};
    const auto expected = shared_renderer()->render(few, 0, sampling),
               found = shared_renderer()->render(many, 0, sampling);
    ASSERT_GT(found.irradiance.size(), 16u + 12u);
    for (const std::size_t image : {0u, 3u, 4u, 9u})  // steps, then bits of x: the same in both
      for (std::size_t i = 0; i < expected.irradiance[image].size(); ++i) {
        const auto light = static_cast<double>(expected.irradiance[image].data[i]);
        ASSERT_NEAR(static_cast<double>(found.irradiance[image].data[i]), light, 0.06 * light + 0.05)
            << image << ' ' << i;
      }
  }
}

// The noise that the renderer states is that between seeds.
TEST(AllBounces, StateTheirNoise) {
  REQUIRE_RENDERER();
  Twin twin = groove(0.8);
  twin.fringes.directions[0] = {Axis::x, {12.0}, {0.0}, {}};
  twin.render.bounces = kAllBounces;
  const render::Sampling adaptive = render::choose_sampling(twin);
  constexpr int kSeeds = 6;
  std::vector<render::Transport> seen;
  for (int seed = 0; seed < kSeeds; ++seed) seen.push_back(shared_renderer()->trace(twin, 0, adaptive, seed));
  Errors phase;
  for (std::size_t i = 0; i < seen[0].mean.size(); ++i) {
    if (!(seen[0].mean.data[i] > 0.0F)) continue;
    for (int seed = 0; seed + 1 < kSeeds; seed += 2) {
      const auto light = [&](int k) {
        return std::complex<double>(static_cast<double>(seen[k].cosine[0][0].data[i]),
                                    static_cast<double>(seen[k].sine[0][0].data[i]));
      };
      if (std::abs(light(seed)) > 1.0)
        phase.add(std::arg(light(seed) * std::conj(light(seed + 1))) / std::sqrt(2.0));
    }
  }
  ASSERT_TRUE(seen[0].estimate.has_value());
  std::cout << "noise of the phase: " << phase.rms() << " rad between seeds, stated "
            << seen[0].estimate->phase_rad << '\n';
  EXPECT_LE(phase.rms(), seen[0].estimate->phase_rad);        // an upper bound
  EXPECT_GE(phase.rms(), 0.2 * seen[0].estimate->phase_rad);  // that says something
}

}  // namespace
}  // namespace fringetwin::testing::bounces_test
