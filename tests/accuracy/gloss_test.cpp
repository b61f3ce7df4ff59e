// SPDX-License-Identifier: Apache-2.0
// Light between surfaces that leaves them by their lobes ([render] glossy_bounces).
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <iostream>
#include <numbers>
#include <tuple>

#include "tests/support/agreement.hpp"
#include "tests/support/expect_agreement.hpp"
#include "tests/support/groove.hpp"
#include "tests/support/paper_rig.hpp"

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
      if (share <= 0.0 || along < 2.0 || along > kWallMm - 2.0 || std::abs(q.y()) > 28.0) continue;
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
  EXPECT_LE(light.rms(), 0.03);
  EXPECT_LE(phase.rms(), 0.03);
}

TEST(Gloss, UnderFringesAgreesWithTheReference) {
  REQUIRE_RENDERER();
  const render::Sampling sampling{Sampler::gauss, 16};
  const Material phong{.diffuse = 0.5, .specular = 0.3, .shininess = 20.0};
  for (const auto& [name, material, bounces] :
       {std::tuple{"GGX 0.3", ggx(0.5, 0.3, 0.3), 1}, std::tuple{"GGX 0.6", ggx(0.5, 0.3, 0.6), 1},
        std::tuple{"Phong 20", phong, 1}, std::tuple{"GGX 0.4, all", ggx(0.5, 0.2, 0.4), kAllBounces}}) {
    Twin twin = shiny_groove(material, material);
    twin.render.bounces = bounces;
    const auto truth = reference_block(render::Reference(twin), 0, {20, 20, 120, 80, 17},
                                       {.gauss_n = 2, .bounce_n = 128, .paths = 2});
    Twin dull = twin;
    dull.render.glossy_bounces = false;
    const Differences without = differences(twin, shared_renderer()->trace(dull, 0, sampling), truth);
    for (const int n : {256, 16384}) {
      twin.render.bounce_samples = n;
      const Differences d = differences(twin, shared_renderer()->trace(twin, 0, sampling), truth);
      std::cout << name << ", " << n << " directions: " << d.gray.n << " pixels, phase " << d.phase_rad.rms()
                << " rad rms, mean " << d.phase_rad.mean() << " (without " << without.phase_rad.rms()
                << "), gray " << d.gray.rms() << ", mean " << d.gray.mean() << " of full scale (without "
                << without.gray.rms() << ")\n";
    }
  }
}

}  // namespace
}  // namespace fringetwin::testing::gloss_test
