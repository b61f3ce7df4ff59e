// SPDX-License-Identifier: Apache-2.0
// Surfaces and the camera's lens: GGX lobe, albedo maps, interreflection, vignetting, point spread.
// | tolerance | unit           | origin                                                              |
// |-----------|----------------|---------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                  |
// | 5e-5      | full scale rms | as for the shapes                                                   |
// | 1e-5      | relative       | fp32 against a closed form at a pixel's centre                       |
// | 3e-4      | full scale rms | point spread: discrete kernel against the continuous one, sphere rim  |
// | 1 %, 4 %  | of the indirect| mean and rms over pixels of 256 directions, uniform wall             |
// | 1.5 %, 6 %|                | the same with fringes on the wall: slope, rms (1/sqrt(256) = 6 %)    |
// | 0         |                | off = bitwise the same image                                         |
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iostream>
#include <numbers>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::materials_test {
namespace {

using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;

Twin window(const Shape& shape, const Vector3d& at = {0, 0, 290}, int width = 120, int height = 90) {
  return with_object(left_window(at, width, height), "surface", shape);
}

Material ggx(double reflectance, double roughness) {
  Material m;
  m.specular = reflectance;
  m.specular_model = Material::Specular::ggx;
  m.roughness = roughness;
  return m;
}

/// Camera and projector in one place, looking along z.
Twin coaxial() {
  Twin twin = only_camera(paper_rig(), 0);
  twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {1000, 1000, 60, 45}, {121, 91}, "camera");
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {1700, 1700, 640, 360}, {1280, 720}, "projector");
  twin.projector->T_proj_world = {};
  return with_object(twin, "plane", frontal_plane());
}

// ---------------------------------------------------------------- GGX

TEST(Ggx, RetroreflectionHasAClosedForm) {
  REQUIRE_RENDERER();
  // N = L = E in the middle: f = F0 D / 4, D = 1/(pi alpha^2); elsewhere, at the angle t:
  // D = alpha^2 / (pi cos^4 t (alpha^2 + tan^2 t)^2), G1^2, F = F0 (H = L).
  Twin twin = coaxial();
  twin.objects[0].material = ggx(0.3, 0.6);
  const auto transport = shared_renderer()->trace(twin, 0, {Sampler::gauss, 9});
  const double a2 = std::pow(0.6, 4);
  for (const int x : {60, 90, 120}) {
    const double tan2 = std::pow((x - 60) / 1000.0, 2), cosine = 1.0 / std::sqrt(1.0 + tan2);
    const double D = a2 / (pi * std::pow(cosine, 4) * std::pow(a2 + tan2, 2));
    const double G1 = 2.0 / (1.0 + std::sqrt(1.0 + a2 * tan2));
    const double expected = 40.0 * cosine * (0.8 / pi + 0.3 * D * G1 * G1 / (4.0 * cosine * cosine));
    EXPECT_NEAR(transport.mean(x, 45) / expected, 1.0, 1e-5) << x;
  }
}

TEST(Ggx, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = window(physical_sphere(), physical_sphere().center_mm, 240, 200);
  const Twin lambert = twin;
  for (const double roughness : {0.35, 0.7, 1.0}) {
    twin.objects[0].material = ggx(0.08, roughness);
    expect_agreement(twin, "GGX, roughness " + std::to_string(roughness), 500, 7);
  }
  twin.objects[0].material = ggx(0.0, 0.7);
  expect_same_bits(lambert, twin);  // no reflectance, no lobe
}

TEST(Ggx, BesidePhongInOneSceneAndLinearInTheLight) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  twin.objects[0].material.specular = 0.3;
  twin.objects.push_back({"sphere", SphereShape{{0, 0, 270}, 4.0}, ggx(0.2, 0.5)});
  expect_agreement(twin, "Phong and GGX", 300);
  expect_linear_in_the_light(twin);
}

// ---------------------------------------------------------------- albedo maps

PlaneShape tile(double side_mm) {
  PlaneShape p = tilted_plane();
  p.size_mm = Eigen::Vector2d(side_mm, 0.75 * side_mm);
  p.u_axis = (p.u_axis + 0.2 * p.normal.cross(p.u_axis)).normalized();
  return p;
}

std::shared_ptr<const ImageF> waves(int width, int height) {
  ImageF map(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      map(x, y) = static_cast<float>(0.5 + 0.2 * std::sin(0.9 * x) + 0.25 * std::cos(0.7 * y + 0.2 * x));
  return std::make_shared<const ImageF>(std::move(map));
}

TEST(AlbedoMap, AgreesWithTheReference) {
  REQUIRE_RENDERER();
  PlaneShape p = tile(60.0);
  const Twin plain = window(p);
  p.albedo_map = std::make_shared<const ImageF>(ImageF(3, 2, 1.0F));
  const Twin white = window(p);
  const auto a = render_fixed(plain), b = render_fixed(white);
  for (std::size_t k = 0; k < a.irradiance[0].size(); ++k)
    ASSERT_NEAR(a.irradiance[3].data[k], b.irradiance[3].data[k], 2e-6);
  p.albedo_map = waves(40, 30);  // its pixels are 1.5 mm, 12 camera pixels
  Twin twin = with_object(window(p), "behind", frontal_plane());
  twin.objects.push_back({"small", SphereShape{{2, 1, 270}, 2.0}, {}});
  // bilinear interpolation has kinks: compared at the same points
  const Agreement agrees =
      agreement(twin, 0, {Sampler::gauss, 16}, whole_image(twin, 0, 3), Pixels::interior, {.gauss_n = 4});
  std::cout << "albedo map: " << agrees.text() << "\n";
  EXPECT_GT(agrees.n, 500);
  EXPECT_LE(agrees.worst_phase_rms_rad(), kPhaseLimit_rad);
  EXPECT_LE(agrees.gray_rms, kGrayLimit);
}

TEST(AlbedoMap, HasItsFirstPixelAtTheCornerOfNegativeUAndV) {
  REQUIRE_RENDERER();
  Twin twin = coaxial();
  auto& p = std::get<PlaneShape>(twin.objects[0].shape);
  p.size_mm = Eigen::Vector2d(20.0, 10.0);
  ImageF map(2, 1);
  map.data = {0.25F, 1.0F};
  p.albedo_map = std::make_shared<const ImageF>(map);
  const auto t = shared_renderer()->trace(twin, 0, {Sampler::gauss, 4});
  // u = x, v = n x u = (0, 0, -1) x (1, 0, 0) = -y; pixel centres at u = -5 and 5 mm, 3.33 px per mm
  EXPECT_NEAR(t.mean(60 + 17, 45) / t.mean(60 - 17, 45), 4.0, 4e-3);
  EXPECT_NEAR(t.mean(60, 45) / t.mean(60 + 17, 45), 0.625, 1e-3);
  map = ImageF(1, 2);
  map.data = {0.25F, 1.0F};
  p.albedo_map = std::make_shared<const ImageF>(map);
  const auto rows = shared_renderer()->trace(twin, 0, {Sampler::gauss, 4});
  EXPECT_NEAR(rows.mean(60, 45 - 10) / rows.mean(60, 45 + 10), 4.0, 4e-3);
  p.albedo_map.reset();
  p.albedo_file = "not-loaded.png";
  EXPECT_THROW(shared_renderer()->trace(twin, 0, {Sampler::gauss, 4}), UserError);
}

// ---------------------------------------------------------------- interreflection

/// A floor (z = 300) and a wall 40 mm wide and 20 mm high at x = -5 mm, lit from afar along (-1, 0, 1).
Twin corner() {
  Twin twin = left_window({5, 0, 300}, 150, 60);
  twin.projector->inverse_square = false;
  const double far_mm = 1e5;
  const Eigen::Matrix3d R = rotation_from_vector({0.0, pi / 4, 0.0});
  twin.projector->T_proj_world = {R, R * Vector3d(-far_mm, 0.0, -(300.0 - far_mm))};
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {1.8e6, 1.8e6, 640, 360}, {1280, 720}, "from afar");
  twin = with_object(twin, "floor", frontal_plane(), {0.6, 0.0, 10.0});
  PlaneShape wall{.point_mm = {-5.0, 0.0, 290.0},
                  .normal = {1, 0, 0},
                  .size_mm = Eigen::Vector2d(40.0, 20.0),
                  .u_axis = {0, 1, 0}};
  return with_object(twin, "wall", wall, {0.9, 0.0, 10.0});
}

// View factor from a small horizontal area at the distance c of a vertical rectangle (height a, width b,
// opposite its corner): (atan(1/Y) - Y/sqrt(X^2+Y^2) atan(1/sqrt(X^2+Y^2)))/(2 pi), X = a/b, Y = c/b
// (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-4).
double view_factor(double c, double a, double b) {
  const double X = a / b, Y = c / b, r = std::hypot(X, Y);
  return (std::atan(1.0 / Y) - Y / r * std::atan(1.0 / r)) / (2.0 * pi);
}

TEST(Interreflection, OfAWallHasTheViewFactorsClosedForm) {
  REQUIRE_RENDERER();
  Twin twin = corner();
  const render::Sampling sampling{Sampler::gauss, 4};
  const auto direct = shared_renderer()->trace(twin, 0, sampling);
  twin.render.bounces = 1;
  twin.render.bounce_samples = 256;
  const auto both = shared_renderer()->trace(twin, 0, sampling);
  const render::Reference reference(twin);
  double sum = 0.0, sum_sq = 0.0, largest = 0.0;
  int n = 0;
  for (int y = 5; y < 55; y += 5)
    for (int x = 10; x < 140; x += 3) {
      const auto s = reference.sample(0, {static_cast<double>(x), static_cast<double>(y)});
      const Vector3d p = s.point_world_mm;
      if (s.object != 0 || !s.lit || p.x() < -3.0) continue;
      const double F =
          view_factor(p.x() + 5.0, 20.0, 20.0 - p.y()) + view_factor(p.x() + 5.0, 20.0, 20.0 + p.y());
      const double wall = 0.9 / pi * 40.0 * std::sqrt(0.5);  // radiance of the wall
      const double expected = 0.6 * wall * F;
      const double error = (both.mean(x, y) - direct.mean(x, y)) / expected - 1.0;
      largest = std::max(largest, expected / direct.mean(x, y));
      sum += error;
      sum_sq += error * error;
      ++n;
    }
  std::cout << "view factor: " << n << " pixels, mean error " << sum / n << ", rms " << std::sqrt(sum_sq / n)
            << ", up to " << largest << " of the direct light\n";
  EXPECT_GT(n, 200);
  EXPECT_GT(largest, 0.1);
  EXPECT_LE(std::abs(sum / n), 0.01);
  EXPECT_LE(std::sqrt(sum_sq / n), 0.04);
}

TEST(Interreflection, AgreesWithTheReferenceInEveryImage) {
  REQUIRE_RENDERER();
  Twin twin = corner();
  twin.render.bounces = 1;
  twin.render.bounce_samples = 256;
  const auto rendered = shared_renderer()->render(twin, 0, {Sampler::gauss, 4});
  Twin dark = twin;
  dark.render.bounces = 0;
  const auto direct = shared_renderer()->render(dark, 0, {Sampler::gauss, 4});
  const render::Reference reference(twin);
  double error = 0.0, light = 0.0, both = 0.0;
  int n = 0;
  for (const auto& p : reference_block(reference, 0, {20, 10, 110, 40, 17}, {.gauss_n = 1, .bounce_n = 64})) {
    if (!p.interior || p.pixel.object != 0) continue;
    ++n;
    const auto alone =
        reference_block(render::Reference(dark), 0, {p.x, p.y, 1, 1, 1}, {.gauss_n = 1}).front();
    for (std::size_t i = 0; i < rendered.irradiance.size(); ++i) {
      const double truth = p.pixel.irradiance[i] - alone.pixel.irradiance[i];
      const double found = rendered.irradiance[i](p.x, p.y) - direct.irradiance[i](p.x, p.y);
      error += std::pow(found - truth, 2);
      both += found * truth;
      light += truth * truth;
    }
  }
  std::cout << "interreflection: " << n << " pixels, rms error " << std::sqrt(error / light)
            << " of the indirect light\n";
  EXPECT_GT(n, 8);
  EXPECT_NEAR(both / light, 1.0, 0.015);
  EXPECT_LE(std::sqrt(error / light), 0.06);
}

TEST(Interreflection, IsTheSameForTheSameSeedAndLinearInTheLight) {
  REQUIRE_RENDERER();
  Twin twin = corner();
  twin.render.bounce_samples = 16;  // bounces = 0: of no effect
  Twin plain = corner();
  expect_same_bits(plain, twin);
  twin.render.bounces = 1;
  const auto a = shared_renderer()->render(twin, 0, {Sampler::gauss, 4}, 5);
  const auto b = shared_renderer()->render(twin, 0, {Sampler::gauss, 4}, 5);
  const auto c = shared_renderer()->render(twin, 0, {Sampler::gauss, 4}, 6);
  twin.projector->intensity *= 2.0;
  const auto d = shared_renderer()->render(twin, 0, {Sampler::gauss, 4}, 5);
  EXPECT_EQ(a.irradiance[2].data, b.irradiance[2].data);
  EXPECT_NE(a.irradiance[2].data, c.irradiance[2].data);
  for (std::size_t p = 0; p < a.irradiance[2].size(); ++p)
    ASSERT_EQ(2.0F * a.irradiance[2].data[p], d.irradiance[2].data[p]);
}

// ---------------------------------------------------------------- the camera's lens

TEST(CameraLens, VignettingAgreesWithTheReference) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  twin.projector->ambient = 0.5;
  // One factor per pixel leaves out how it changes inside: grad(phase) . grad(ln v)/12 of phase, 1e-5 rad
  // for a loss of 40 % over 1440x1080 px; here the window is a tenth of that, and so is the loss.
  const Twin plain = twin;
  twin.cameras[0].vignetting = {Vignetting::Kind::polynomial, {-0.04, 0.01, 0.0}};
  expect_agreement(twin, "polynomial", 500);
  twin.cameras[0].vignetting = {Vignetting::Kind::polynomial, {0.0, 0.0, 0.0}, {0.03, -0.02}};
  expect_agreement(twin, "tilt", 500);
  twin.cameras[0].vignetting = {Vignetting::Kind::cos4, {}};
  expect_agreement(twin, "cos^4", 500);
  twin.cameras[0].vignetting.kind = Vignetting::Kind::none;
  expect_same_bits(plain, twin);
}

TEST(CameraLens, PointSpreadAgreesWithTheContinuousOne) {
  REQUIRE_RENDERER();
  Twin twin = window(tilted_plane());
  for (const double sigma : {0.4, 1.0}) {
    twin.cameras[0].psf_px = sigma;
    const render::Reference reference(twin);
    // away from the border, where the renderer knows nothing of what lies outside
    const auto truth = reference_block(reference, 0, {20, 20, 80, 50, 11}, {.gauss_n = 3});
    for (const bool by_default : {false, true}) {
      const auto rendered =
          by_default ? shared_renderer()->render(twin, 0, render::choose_sampling(twin)) : render_fixed(twin);
      const Agreement a = compare(twin, 0, rendered.irradiance, truth);
      std::cout << "point spread " << sigma << (by_default ? " px, default: " : " px: ") << a.text() << "\n";
      EXPECT_GE(a.n, 30);
      EXPECT_LE(a.worst_phase_rms_rad(), 1e-4);
      EXPECT_LE(a.gray_rms, 3e-4);
    }
  }
}

}  // namespace
}  // namespace fringetwin::testing::materials_test
