// SPDX-License-Identifier: Apache-2.0
// Shadow rays: no surface shades itself by rounding, at any scale; gaps and contacts keep their shadows.
// | tolerance | unit   | origin                                                                       |
// |-----------|--------|------------------------------------------------------------------------------|
// | 0         | pixels | lit side of a convex mesh: nothing may be dark                                |
// | 0.3       | %      | pixels of a shadow's border that decide one of four samples otherwise          |
// | 3e-4      | mm     | shadow rays start 1e-6 of the distance above the surface: so much of a gap is lost |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/support/freeform.hpp"
#include "tests/support/hard_support.hpp"

namespace fringetwin::testing::shadows_test {
namespace {

using Eigen::Vector3d;

struct Wrong {
  int pixels = 0, dark = 0, bright = 0;  // by more than 1 % of what the reference says, or of full light
};
Wrong wrong_pixels(const Twin& twin, int stride = 2) {
  const auto t = shared_renderer()->trace(twin, 0, {Sampler::gauss, 4});
  const auto truth =
      reference_block(render::Reference(twin), 0, whole_image(twin, 0, stride), {.gauss_n = 2});
  double full = 0.0;
  for (const auto& p : truth) full = std::max(full, p.pixel.mean);
  Wrong out;
  for (const auto& p : truth) {
    ++out.pixels;
    const double d = t.mean(p.x, p.y) - p.pixel.mean;
    out.dark += d < -0.01 * full;
    out.bright += d > 0.01 * full;
  }
  return out;
}

/// Share of points o + t d in single precision that lie more than `epsilon_mm` below their own plane.
double below_percent(const Twin& twin, double epsilon_mm) {
  const render::Reference reference(twin);
  int n = 0, below = 0;
  for (int y = 0; y < twin.cameras[0].lens.height(); y += 2)
    for (int x = 0; x < twin.cameras[0].lens.width(); x += 2) {
      const auto s = reference.sample(0, {x, y});
      if (!s.lit) continue;
      const Eigen::Vector3f d = twin.cameras[0].lens.unproject({x, y})->cast<float>();
      const Vector3d p = (static_cast<float>(s.t_mm) * d).cast<double>();
      ++n;
      below += s.normal_world.dot(p - s.point_world_mm) < -epsilon_mm;
    }
  return 100.0 * below / n;
}

Twin window(double k) {
  return crop_around(scaled(only_camera(paper_rig(), 0), k), Vector3d(0, 0, 250 * k), 240, 200);
}

// A convex mesh: no facet shades another, whatever the scale and the incidence.
TEST(HardShadows, ConvexMeshesHaveNoAcne) {
  REQUIRE_RENDERER();
  for (const double k : {0.01, 1.0, 40.0, 1000.0}) {
    const Pose T = {rotation_from_vector({0.1, 0.2, 0.3}), Vector3d(0, 0, 258 * k)};
    const Twin twin = with_object(window(k), "ball", as_shape(make_bumpy_icosphere(5, 10 * k, {}), T));
    const Wrong w = wrong_pixels(twin);
    const double fixed = below_percent(twin, 1e-4);
    report(fmt::format("convex mesh of 20,480 facets at {} mm", 250 * k),
           fmt::format("fixed offset of 1e-4 mm: {:.0f} % of the points start below their facet", fixed),
           fmt::format("{} of {} pixels too dark, {} too bright", w.dark, w.pixels, w.bright));
    EXPECT_EQ(w.dark, 0);
    EXPECT_EQ(w.bright, 0);
  }
}

// A flat sheet of many facets under light at 89.5 degrees: neighbours lie in one plane.
TEST(HardShadows, FlatMeshUnderGrazingLight) {
  REQUIRE_RENDERER();
  for (const double k : {1.0, 40.0}) {
    Twin twin = window(k);
    const Pose T = {rotation_from_vector({0.3, -0.2, 0.5}), Vector3d(0, 0, 260 * k)};
    const Vector3d n = -T.rotation.col(2), along = T.rotation.col(0);
    const Vector3d center = T.translation_mm + 300.0 * k * (std::cos(0.0087) * along + std::sin(0.0087) * n);
    const Vector3d z = (T.translation_mm - center).normalized(), x = n.cross(z).normalized(), y = z.cross(x);
    Eigen::Matrix3d R;
    R.row(0) = x, R.row(1) = y, R.row(2) = z;
    twin.projector->T_proj_world = {R, -R * center};
    twin = with_object(twin, "sheet",
                       as_shape(height_field(-30 * k, -30 * k, 0.5 * k, 0.5 * k, 120, 120,
                                             [](double, double) { return 0.0; }),
                                T));
    const auto t = shared_renderer()->trace(twin, 0, {Sampler::gauss, 4});
    const render::Reference reference(twin);
    int lit = 0, dark = 0;
    for (int py = 0; py < 200; ++py)
      for (int px = 0; px < 240; ++px)
        if (reference.is_whole(0, px, py) || t.object(px, py) == 0) {
          const auto s = reference.sample(0, {px, py});
          if (s.object != 0 || (s.point_world_mm - T.translation_mm).cwiseAbs().maxCoeff() > 9 * k) continue;
          ++lit;
          dark += t.mean(px, py) < 0.9F * 40.0F * 0.8F / 3.1416F * 0.0087F * 0.9F;
        }
    report(fmt::format("flat mesh under light at 89.5 deg, {} mm away", 260 * k), "",
           fmt::format("{} of {} pixels dark", dark, lit));
    EXPECT_GT(lit, 10'000);
    EXPECT_EQ(dark, 0);
  }
}

// A blade that ends `gap` above a plane: the light passes below it, the shadow's border moves by the
// gap's size. A ball that touches the plane: its shadow starts at the contact.
TEST(HardShadows, GapsAndContacts) {
  REQUIRE_RENDERER();
  for (const double gap : {1.0, 0.1, 0.01, 0.001, 0.0}) {
    Twin twin = left_window({-2, 0, 300}, 160, 160);
    twin = with_object(twin, "floor", frontal_plane(300.0));
    PlaneShape blade;  // from the floor 20 mm towards the camera, across the light
    blade.normal = Vector3d(1, 0, 0.25).normalized();
    const Vector3d up = Vector3d(0.25, 0, -1).normalized();
    blade.u_axis = Vector3d::UnitY();
    blade.size_mm = Eigen::Vector2d(30, 20);
    blade.point_mm = Vector3d(-1.5, 0, 300) + (10.0 + gap / std::abs(up.z())) * up;
    twin = with_object(twin, "blade", blade);
    const Wrong w = wrong_pixels(twin);
    report(fmt::format("blade {} mm above a plane", gap), "",
           fmt::format("{} of {} pixels differ", w.dark + w.bright, w.pixels));
    EXPECT_LE(w.dark + w.bright, 0.003 * w.pixels);
  }
  for (const double k : {0.02, 1.0, 40.0}) {
    Twin twin = with_object(window(k), "ball", SphereShape{{0, 0, 290 * k}, 10.0 * k});
    twin = with_object(twin, "floor", frontal_plane(300.0 * k));
    const Wrong w = wrong_pixels(twin);
    report(fmt::format("ball R {} mm touching a plane", 10 * k), "",
           fmt::format("{} of {} pixels differ", w.dark + w.bright, w.pixels));
    EXPECT_LE(w.dark + w.bright, 0.003 * w.pixels);
  }
}

// Two sheets of a mesh, `gap` apart: the upper one keeps the lower one dark, however close. A fixed offset
// of more than the gap starts the shadow rays above both.
TEST(HardShadows, SheetOverSheet) {
  REQUIRE_RENDERER();
  for (const double gap : {1.0, 0.1, 0.01, 0.004, 0.002}) {
    Twin twin = bench_rig(1000.0, 120, 120, 400.0);  // light from 53 degrees
    twin.projector->T_proj_world.rotation = rotation_from_vector({0.0, 0.93, 0.0});
    twin.projector->T_proj_world.translation_mm =
        -(twin.projector->T_proj_world.rotation * Vector3d(400, 0, 0));
    // The upper sheet covers x > 0 as seen by the camera; the light comes from +x, so the lower sheet is in
    // its shadow for a strip of gap tan(53 deg) left of x = 0.
    PlaneShape lower = frontal_plane(300.0), upper = frontal_plane(300.0 - gap);
    upper.size_mm = Eigen::Vector2d(60, 100);
    upper.point_mm.x() = 30.0;
    twin = with_object(with_object(twin, "lower", lower), "upper", upper);
    const double f_px = 9000.0 / gap;  // the strip is 40 px wide
    twin.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {f_px, f_px, 59.5, 59.5}, {120, 120}, "camera");
    const Wrong w = wrong_pixels(twin);
    const auto truth = reference_block(render::Reference(twin), 0, whole_image(twin, 0, 2), {.gauss_n = 2});
    int shadow = 0;
    for (const auto& p : truth) shadow += p.pixel.mean == 0.0;
    report(fmt::format("sheet {} mm over a sheet, {} pixels in shadow", gap, shadow), "",
           fmt::format("{} too bright, {} too dark", w.bright, w.dark));
    EXPECT_GT(shadow, 100);
    EXPECT_LE(w.bright, (3e-4 / gap + 0.06) * shadow);
  }
}

}  // namespace
}  // namespace fringetwin::testing::shadows_test
