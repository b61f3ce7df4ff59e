// SPDX-License-Identifier: Apache-2.0
// Grazing views and grazing light to 89.9 degrees, the terminator, the limb.
// Single precision rounds a ray as if its pixel had moved by about 6e-8 f |d| (5e-5 px for f = 2,400 px);
// on a grazing surface that shift meets a steep phase.
// | tolerance | unit           | origin                                                              |
// |-----------|----------------|---------------------------------------------------------------------|
// | 2.4e-7    | f px           | four roundings of the ray, times the phase gradient of the block     |
// | 1e-5      | rad rms        | the target asked of the kernel in double                             |
// | 1e-5      | full scale rms | shading in single precision                                          |
// | 2e-4      | relative       | N.L = 1.7e-3 of normals and directions rounded to 6e-8: 7e-5          |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/hard_support.hpp"

namespace fringetwin::testing::grazing_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
constexpr double deg = std::numbers::pi / 180.0;

/// A plane at `angle_deg` to the line of sight of a camera window off its lens's axis; the projector
/// stands on the side that sees it better.
Twin grazing_view(double f_px, double angle_deg, double baseline_mm) {
  const int width = 120, height = 100;
  Twin twin = bench_rig(f_px, width, height, baseline_mm);
  const Vector3d d(0.25, 0.12, 1.0);
  twin.cameras[0].lens =
      Lens("LENSMODEL_PINHOLE", {f_px, f_px, width / 2 - d.x() * f_px, height / 2 - d.y() * f_px},
           {width, height}, "off-axis window");
  const Vector3d view = d.normalized(), e = (Vector3d::UnitX() - view.x() * view).normalized();
  PlaneShape plane = frontal_plane();
  plane.point_mm = 300.0 * d;
  plane.normal = (std::sin(angle_deg * deg) * e - std::cos(angle_deg * deg) * view).normalized();
  plane.u_axis = view.cross(e);
  return with_object(twin, "plane", plane);
}

/// Rms over the block of the phase's change from a pixel to the next, rad/px.
double phase_gradient(const render::Reference& reference, double pitch_px) {
  double sum = 0.0;
  int n = 0;
  for (int y = 5; y < 95; y += 10)
    for (int x = 5; x < 115; x += 10) {
      const auto a = reference.sample(0, {x, y}), b = reference.sample(0, {x + 0.01, y});
      if (!a.lit || !b.lit) continue;
      sum +=
          std::pow(2.0 * std::numbers::pi / pitch_px * (b.projector_px.x() - a.projector_px.x()) / 0.01, 2);
      ++n;
    }
  return std::sqrt(sum / std::max(1, n));
}

struct View {
  double f_px, angle_deg, baseline_mm;
};

TEST(Grazing, ViewsOfAPlane) {
  REQUIRE_RENDERER();
  for (const View& view : {View{2400, 80, 40}, View{2400, 89, 10}, View{1e5, 89.9, 10}}) {
    const Twin twin = grazing_view(view.f_px, view.angle_deg, view.baseline_mm);
    const render::Reference reference(twin);
    const double gradient = phase_gradient(reference, 13.0);
    const Agreement a = agreement(twin, 0, render::choose_sampling(twin), whole_image(twin, 0, 3));
    Twin in_double = twin;
    in_double.render.phase_error_rad = 1e-5;
    const Agreement b = agreement(in_double, 0, render::choose_sampling(in_double), whole_image(twin, 0, 3));
    const PlaneShape plane = std::get<PlaneShape>(twin.objects[0].shape);
    const Vector3f n = plane.normal.cast<float>(), p = plane.point_mm.cast<float>();
    const PointError schoolbook = point_error(reference, 0, whole_image(twin, 0, 3), [&](const Vector3d& d) {
      return std::optional<double>(n.dot(p) / n.dot(d.cast<float>().eval()));
    });
    report(fmt::format("view at {} deg, f {:.0f} px, {:.2f} rad/px", view.angle_deg, view.f_px, gradient),
           fmt::format("{:.1e} rad rms", schoolbook.rms_rad),
           fmt::format("{:.1e} rad, target 1e-5: {:.1e}; gray {:.1e}", a.worst_phase_rms_rad(),
                       b.worst_phase_rms_rad(), b.gray_rms));
    EXPECT_GT(a.n, 300);
    EXPECT_LE(a.worst_phase_rms_rad(), std::max(4e-5, 2.4e-7 * view.f_px * gradient));
    EXPECT_LE(b.worst_phase_rms_rad(), 1e-5);
    EXPECT_LE(b.gray_rms, 1e-5);
  }
}

/// Projector at `center`, its axis through `target`, its rows along `across` as far as possible.
void aim_projector(Twin* twin, const Vector3d& center, const Vector3d& target, const Vector3d& down) {
  const Vector3d z = (target - center).normalized(), x = down.cross(z).normalized(), y = z.cross(x);
  Eigen::Matrix3d R;
  R.row(0) = x;
  R.row(1) = y;
  R.row(2) = z;
  twin->projector->T_proj_world = {R, -R * center};
}

TEST(Grazing, LightOnAPlane) {
  REQUIRE_RENDERER();
  for (const double angle : {80.0, 89.0, 89.9}) {
    Twin twin = bench_rig(1000.0, 41, 41);
    const Vector3d target(0, 0, 300);
    aim_projector(&twin, target + 300.0 * Vector3d(std::sin(angle * deg), 0, -std::cos(angle * deg)), target,
                  Vector3d::UnitY());
    twin = with_object(twin, "plane", frontal_plane());
    const auto t = shared_renderer()->trace(twin, 0, {Sampler::gauss, 16});
    const auto truth = reference_block(render::Reference(twin), 0, {2, 2, 37, 37, 1}, {.gauss_n = 4});
    double worst = 0.0, phase = 0.0;
    for (const auto& p : truth) {
      ASSERT_GT(p.pixel.mean, 0.0);
      worst = std::max(worst, std::abs(t.mean(p.x, p.y) / p.pixel.mean - 1.0));
      const double got = std::atan2(t.sine[0][0](p.x, p.y), t.cosine[0][0](p.x, p.y));
      phase = std::max(phase, std::abs(wrap(got - std::atan2(p.pixel.sine[0][0], p.pixel.cosine[0][0]))));
    }
    report(fmt::format("light at {} deg", angle), "",
           fmt::format("w off by {:.1e} at most, phase by {:.1e} rad", worst, phase));
    EXPECT_LE(worst, 2e-4);
    EXPECT_LE(phase, 1e-4);
  }
}

// Sphere and mesh lit from the side: every pixel, dark side, terminator and all, on the same sample
// points, so that only wrong decisions and rounding are left.
TEST(Grazing, Terminator) {
  REQUIRE_RENDERER();
  Twin rig = left_window({0, 0, 250}, 200, 160);
  aim_projector(&rig, Vector3d(280, 30, 240), Vector3d(0, 0, 250), Vector3d::UnitY());
  for (const Shape& shape :
       {Shape(SphereShape{{0, 0, 250}, 8.0}),
        Shape(CylinderShape{{0, 0, 250}, Vector3d(0.1, 1, 0.2).normalized(), 6.0, {}})}) {
    const Twin twin = with_object(rig, "ball", shape);
    const Agreement a =
        agreement(twin, 0, {Sampler::gauss, 16}, whole_image(twin, 0, 1), Pixels::all, {.gauss_n = 4});
    report(fmt::format("terminator of a {}, every pixel", shape_kind(shape)), "",
           fmt::format("gray {:.1e} rms, {:.1e} max", a.gray_rms, a.gray_max));
    EXPECT_LE(a.gray_rms, 5e-5);
    EXPECT_LE(a.gray_max, 2e-3);  // one of 16 samples on the other side of the limb, where it is dim
  }
}

}  // namespace
}  // namespace fringetwin::testing::grazing_test
