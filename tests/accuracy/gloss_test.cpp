// SPDX-License-Identifier: Apache-2.0
// Light between surfaces that leaves them by their lobes ([render] glossy_bounces).
// | tolerance      | of                 | origin                                                         |
// |----------------|--------------------|----------------------------------------------------------------|
// | 1 %, 4 %       | mirrored light     | mean and rms over pixels; 4 times what its 64 directions leave |
// | 0.03 rad rms   | its wide fringes   | a lobe of 1 degree (alpha = 0.01) over fringes of 60 px        |
// | 1e-3 rad rms   | phase              | groove, 16,384 directions, as of diffuse walls                 |
// | 2e-3, 4e-3     | the same           | narrow lobes over one another: 0.4 % of their light, that is   |
// |                |                    | interpolated (light_lattice.hpp), beside as much direct light  |
// | 3e-3, 0.25 %   | phase, full scale  | around a ball: places whose mirrored light is not found        |
// | 0.1 %          | full scale rms     | gray values of the grooves                                     |
// | 5e-3, 0.4 %    | phase, full scale  | twice what lobes in the middle of paths make, which are left out |
// | 2 x the stated | phase, gray        | 256 directions (kBrighter)                                     |
// | 0.8 %          | full scale         | noise around a ball: 0.66 % by its ways, 1.0 % without         |
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "tests/support/agreement.hpp"
#include "tests/support/expect_agreement.hpp"
#include "tests/support/groove.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/mesh/mesh.hpp"

namespace fringetwin::testing::gloss_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;

Material ggx(double diffuse, double reflectance, double roughness) {
  Material m{.diffuse = diffuse, .specular = reflectance};
  m.specular_model = Material::Specular::ggx;
  m.roughness = roughness;
  return m;
}

/// A groove whose walls have given materials, with glossy bounces.
Twin shiny_groove(const Material& left, const Material& right) {
  Twin twin = groove(0.5);
  twin.objects[0].material = left;
  twin.objects[1].material = right;
  twin.render.bounces = 1;
  twin.render.glossy_bounces = true;
  return twin;
}

// The right wall is a mirror (alpha = 0.01, nothing diffuse): on the left one lies the projector's mirror
// image, F (D/(D + t))^2 cos_P of its light, D and t the ways before and after the mirror; by the fringes'
// place there.
TEST(Gloss, OfAMirrorIsTheMirroredProjector) {
  REQUIRE_RENDERER();
  constexpr double kReflectance = 0.5, kDiffuse = 0.6;
  Twin twin = shiny_groove(Material{.diffuse = kDiffuse, .specular = 0.0}, ggx(0.0, kReflectance, 0.1));
  const render::Sampling sampling{Sampler::gauss, 16};
  const auto found = shared_renderer()->trace(twin, 0, sampling);
  const render::Reference reference(twin);
  const Twin dark = [&] {
    Twin t = twin;
    t.render.bounces = 0, t.render.glossy_bounces = false;
    return t;
  }();
  const auto direct = shared_renderer()->trace(dark, 0, sampling);
  const Vector3d from = twin.projector->center_world_mm(), apex(0, 0, kApexMm);
  const Vector3d n = Vector3d(-1, 0, -1).normalized();  // of the right wall
  Errors light, phase;
  for (int y = 30; y < 90; y += 3)
    for (int x = 20; x < 80; ++x) {
      const auto s = reference.sample(0, Vector2d(x, y));
      if (s.object != 0 || !s.lit || !reference.is_whole(0, x, y)) continue;
      const Vector3d p = s.point_world_mm, image = from - 2.0 * (from - apex).dot(n) * n;
      const double share = (apex - p).dot(n) / (image - p).dot(n);
      const Vector3d q = p + share * (image - p);
      const double along = (q - apex).dot(Vector3d(1, 0, -1).normalized());
      if (share <= 0.0 || along < 5.0 || along > kWallMm - 10.0 || std::abs(q.y()) > 28.0) continue;
      const double D = (from - q).norm(), t = (p - q).norm();
      const double cos_p = Vector3d(1, 0, -1).normalized().dot((q - p).normalized());
      const double cos_h = (from - q).normalized().dot(n);
      const double fresnel = kReflectance + (1.0 - kReflectance) * std::pow(1.0 - cos_h, 5);
      const auto px = twin.projector->lens.project(twin.projector->T_proj_world * q);
      if (!px || cos_p <= 0.0) continue;
      const double expected =
          kDiffuse / pi * twin.projector->intensity * fresnel * std::pow(D / (D + t), 2) * cos_p;
      light.add((static_cast<double>(found.mean(x, y)) - static_cast<double>(direct.mean(x, y))) / expected -
                1.0);
      const std::complex<double> fringe(
          static_cast<double>(found.cosine[0][1](x, y)) - static_cast<double>(direct.cosine[0][1](x, y)),
          static_cast<double>(found.sine[0][1](x, y)) - static_cast<double>(direct.sine[0][1](x, y)));
      phase.add(std::arg(fringe * std::polar(1.0, -2.0 * pi * px->x() / 60.0)));
    }
  std::cout << "mirrored projector: " << light.n << " pixels, light off by " << light.mean() << " (mean), "
            << light.rms() << " (rms), phase of wide fringes by " << phase.mean() << ", " << phase.rms()
            << " rad\n";
  EXPECT_GT(light.n, 200);
  EXPECT_LE(std::abs(light.mean()), 0.01);
  EXPECT_LE(light.rms(), 0.04);
  EXPECT_LE(phase.rms(), 0.03);
}

// What is stated is of the whole image; the pixels compared are where there is most light between surfaces.
constexpr double kBrighter = 2.0;

/// Compares glossy bounces with the reference: with many directions within a tolerance, with the usual ones
/// within what is stated. `gray`: of full scale.
void expect_truth(const std::string& name, Twin twin, const PixelBlock& block, double phase_rad,
                  double gray) {
  const auto truth =
      reference_block(render::Reference(twin), 0, block, {.gauss_n = 2, .bounce_n = 128, .paths = 2});
  Twin dull = twin;
  dull.render.glossy_bounces = false;
  const render::Sampling sampling = render::choose_sampling(twin);
  const Differences without = differences(twin, shared_renderer()->trace(dull, 0, sampling), truth);
  const auto usual_trace = shared_renderer()->trace(twin, 0, sampling);
  const Differences usual = differences(twin, usual_trace, truth);
  twin.render.bounce_samples = 16384;
  const Differences many = differences(twin, shared_renderer()->trace(twin, 0, sampling), truth);
  ASSERT_TRUE(usual_trace.estimate.has_value());
  std::cout << name << ": " << many.gray.n << " pixels, phase " << many.phase_rad.rms() << " rad rms, gray "
            << many.gray.rms() << " of full scale; 256 directions: " << usual.phase_rad.rms() << ", "
            << usual.gray.rms() << ", stated " << usual_trace.estimate->phase_rad << ", "
            << usual_trace.estimate->gray << "; without gloss " << without.phase_rad.rms() << ", "
            << without.gray.rms() << '\n';
  EXPECT_GT(many.gray.n, 20) << name;
  EXPECT_LE(many.phase_rad.rms(), phase_rad) << name;
  EXPECT_LE(many.gray.rms(), gray) << name;
  EXPECT_GT(without.gray.rms(), 10.0 * gray) << name;
  EXPECT_LE(usual.phase_rad.rms(), kBrighter * usual_trace.estimate->phase_rad) << name;
  EXPECT_LE(usual.gray.rms(), kBrighter * usual_trace.estimate->gray) << name;
}

const PixelBlock kBlock{20, 20, 120, 80, 17};

TEST(Gloss, InAGrooveAgreesWithTheReference) {
  REQUIRE_RENDERER();
  const Material phong{.diffuse = 0.5, .specular = 0.3, .shininess = 20.0};
  const Material dull{.diffuse = 0.5, .specular = 0.0};
  // two narrow lobes that face one another are off by what interpolation leaves of a third of a radian
  expect_truth("GGX 0.3", shiny_groove(ggx(0.5, 0.3, 0.3), ggx(0.5, 0.3, 0.3)), kBlock, 4e-3, 1e-3);
  expect_truth("GGX 0.6", shiny_groove(ggx(0.5, 0.3, 0.6), ggx(0.5, 0.3, 0.6)), kBlock, 1e-3, 1e-3);
  expect_truth("Phong 20", shiny_groove(phong, phong), kBlock, 1e-3, 1e-3);
  expect_truth("GGX 0.3 seen", shiny_groove(ggx(0.5, 0.3, 0.3), dull), kBlock, 1e-3, 1e-3);
  expect_truth("GGX 0.3 opposite", shiny_groove(dull, ggx(0.5, 0.3, 0.3)), kBlock, 1e-3, 1e-3);
}

TEST(Gloss, OverAnyNumberOfSurfacesAgreesWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = shiny_groove(ggx(0.5, 0.2, 0.4), ggx(0.5, 0.2, 0.4));
  twin.render.bounces = kAllBounces;
  expect_truth("GGX 0.4, all", twin, kBlock, 2e-3, 1e-3);
}

// What is left out: lobes in the middle of a path, of light that has come over a surface already.
TEST(Gloss, WithoutLobesInTheMiddleOfAPathIsNearThatWithThem) {
  REQUIRE_RENDERER();
  Twin twin = shiny_groove(ggx(0.5, 0.2, 0.4), ggx(0.5, 0.2, 0.4));
  twin.render.bounces = kAllBounces;
  twin.render.bounce_samples = 4096;
  const auto truth = reference_block(render::Reference(twin), 0, kBlock,
                                     {.gauss_n = 2, .bounce_n = 96, .paths = 2, .middle_lobes = true});
  const Differences d =
      differences(twin, shared_renderer()->trace(twin, 0, render::choose_sampling(twin)), truth);
  std::cout << "lobes in the middle left out: phase " << d.phase_rad.rms() << " rad rms, gray "
            << d.gray.mean() << " (mean), " << d.gray.rms() << " of full scale\n";
  EXPECT_LT(d.gray.mean(), 0.0);  // it is less light
  EXPECT_LE(d.phase_rad.rms(), 5e-3);
  EXPECT_LE(d.gray.rms(), 4e-3);
}

/// A ball before a wall that is a distance away, with glossy bounces: the rim of a shiny ball mirrors the
/// projector to the wall at grazing angles, from places that few directions meet.
Twin ball_before_wall(const Material& of_ball, const Material& of_wall, double wall_mm) {
  Twin twin = rig_before(300.0);
  twin.render.bounces = 1;
  twin.render.glossy_bounces = true;
  twin = with_object(twin, "wall",
                     PlaneShape{.point_mm = {0, 0, wall_mm},
                                .normal = Vector3d(0.05, -0.08, -1).normalized(),
                                .size_mm = {},
                                .u_axis = {1, 0, 0}},
                     of_wall);
  return with_object(twin, "ball", SphereShape{.center_mm = {2.0, -1.0, 290.0}, .radius_mm = 19.0}, of_ball);
}

Twin ball_before_shiny_wall(const Material& of_ball) {
  return ball_before_wall(of_ball, ggx(0.6, 0.1, 0.4), 314.0);
}

TEST(Gloss, OfABallAgreesWithTheReference) {
  REQUIRE_RENDERER();
  expect_truth("ball", ball_before_shiny_wall(ggx(0.2, 0.5, 0.35)), {10, 10, 140, 100, 17}, 3e-3, 2.5e-3);
}

// One object by Phong's model beside one by GGX's.
TEST(Gloss, OfABallOfAnotherModelAgreesWithTheReference) {
  REQUIRE_RENDERER();
  const Material phong{.diffuse = 0.2, .specular = 0.5, .shininess = 30.0};
  expect_truth("Phong ball", ball_before_shiny_wall(phong), {10, 10, 140, 100, 23}, 1e-3, 1e-3);
}

// Without the ways of mirrored light that Newton's method finds, the same directions leave 1.0 % of full
// scale.
TEST(Gloss, OfABallIsQuietByItsWays) {
  REQUIRE_RENDERER();
  const Twin twin = ball_before_shiny_wall(ggx(0.2, 0.5, 0.35));
  const Sensor& sensor = twin.cameras[0].sensor;
  const render::Sampling sampling = render::choose_sampling(twin);
  Errors gray;
  for (const int seed : {0, 2, 4}) {
    const auto one = shared_renderer()->trace(twin, 0, sampling, seed),
               other = shared_renderer()->trace(twin, 0, sampling, seed + 1);
    for (int y = 10; y < 110; ++y)
      for (int x = 10; x < 150; ++x)
        if (one.mean(x, y) > 0.0F && other.mean(x, y) > 0.0F)
          gray.add((static_cast<double>(one.mean(x, y)) - static_cast<double>(other.mean(x, y))) /
                   std::numbers::sqrt2 * sensor.gain_dn / sensor.max_dn());
  }
  std::cout << "ball: " << gray.n << " values, noise " << gray.rms() << " of full scale\n";
  EXPECT_GT(gray.n, 10'000);
  EXPECT_LE(gray.rms(), 8e-3);  // 0.66 % with them
  EXPECT_GE(gray.rms(), 2e-3) << "seeds are alike";
}

// A wall of triangles mirrors as the wall itself does.
TEST(Gloss, OfAMeshIsThatOfItsPlane) {
  REQUIRE_RENDERER();
  Twin twin = shiny_groove({.diffuse = 0.5, .specular = 0.0}, ggx(0.4, 0.3, 0.3));
  twin.render.bounce_samples = 4096;
  Twin of_mesh = twin;
  const auto& wall = std::get<PlaneShape>(twin.objects[1].shape);
  const Vector3d u = 0.5 * wall.size_mm->x() * wall.u_axis,
                 v = 0.5 * wall.size_mm->y() * wall.normal.cross(wall.u_axis);
  Mesh mesh;
  for (const auto& [a, b] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}})
    mesh.vertices_mm.push_back((wall.point_mm + a * u + b * v).cast<float>());
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  MeshShape shape;
  shape.mesh = std::make_shared<const Mesh>(mesh);
  of_mesh.objects[1].shape = shape;
  const render::Sampling sampling{Sampler::gauss, 16};
  const auto expected = shared_renderer()->trace(twin, 0, sampling),
             found = shared_renderer()->trace(of_mesh, 0, sampling);
  Errors light;
  for (int y = 25; y < 95; y += 3)
    for (int x = 20; x < 140; x += 3)
      light.add(static_cast<double>(found.mean(x, y)) / static_cast<double>(expected.mean(x, y)) - 1.0);
  std::cout << "wall of triangles: light off by " << light.mean() << ", " << light.rms() << " rms\n";
  EXPECT_LE(std::abs(light.mean()), 1e-3);
  EXPECT_LE(light.rms(), 0.01);
}

// The ball's back gets mirrored light of the wall behind it, on places that face away from the camera, and
// sends it back; and light that goes below the mirror's surface is not what its lobe reflects.
TEST(Gloss, OverPlacesThatFaceAwayAndBelowAMirrorAgreesWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = ball_before_wall({.diffuse = 0.8, .specular = 0.0}, ggx(0.3, 0.6, 0.3), 318.0);
  twin.render.bounces = kAllBounces;
  expect_truth("ball before a mirror", twin, {10, 10, 140, 100, 17}, 1e-3, 5e-4);
  Twin waxy = shiny_groove({.diffuse = 0.5, .specular = 0.0}, ggx(0.5, 0.3, 0.3));
  waxy.objects[1].material.mean_free_path_mm = 2.0;
  expect_truth("waxy mirror", waxy, kBlock, 1e-3, 1e-3);
}

TEST(Gloss, WithoutALobeIsTheSameBits) {
  REQUIRE_RENDERER();
  Twin twin = shiny_groove({.diffuse = 0.5, .specular = 0.0}, {.diffuse = 0.5, .specular = 0.0});
  Twin off = twin;
  off.render.glossy_bounces = false;
  expect_same_bits(off, twin);  // no lobe, no gloss
}

}  // namespace
}  // namespace fringetwin::testing::gloss_test
