// SPDX-License-Identifier: Apache-2.0
// Spheres from 0.1 mm to 10 m, small things 10 m away, a world whose origin is far off. Truth: the
// double-precision reference, interior pixels; schoolbook: the quadratic formula in single precision.
// | tolerance | unit           | origin                                                               |
// |-----------|----------------|----------------------------------------------------------------------|
// | 5e-5      | rad rms        | stated floor of single precision (render::single_precision_error_rad) |
// | 5e-5      | full scale rms | required                                                              |
// | 1e-4      | rad rms        | default target where the kernel in double takes over by itself        |
// | 2e-6      | relative       | world moved by 10 m: transforms in double, then the same floats +- 1 ulp |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/hard_support.hpp"

namespace fringetwin::testing::spheres_test {
namespace {

using Eigen::Vector3d;

struct Limits {
  double phase_rad = 5e-5, gray = 5e-5;  // single_precision_error_rad of this rig
};

/// Default sampling on the interior of a block, every camera; prints both errors.
void expect_sphere(const std::string& what, const Twin& twin,
                   const std::function<PixelBlock(std::size_t)>& block, const Limits& limits = {}) {
  const SphereShape sphere = std::get<SphereShape>(twin.objects[0].shape);
  const render::Sampling sampling = render::choose_sampling(twin);
  const render::Reference reference(twin);
  for (std::size_t camera = 0; camera < twin.cameras.size(); ++camera) {
    const Agreement a = agreement(twin, camera, sampling, block(camera));
    EXPECT_GT(a.n, 80) << what;
    EXPECT_LE(a.worst_phase_rms_rad(), limits.phase_rad) << what;
    EXPECT_LE(a.gray_rms, limits.gray) << what;
    const Camera& c = twin.cameras[camera];
    const Eigen::Vector3f center = (c.T_cam_world * sphere.center_mm).cast<float>();
    const PointError schoolbook = point_error(reference, camera, block(camera), [&](const Vector3d& d) {
      const auto t = schoolbook_sphere(Eigen::Vector3f::Zero(), (c.T_cam_world.rotation * d).cast<float>(),
                                       center, static_cast<float>(sphere.radius_mm));
      return t ? std::optional<double>(*t) : std::nullopt;
    });
    report(fmt::format("{}, {}", what, c.name),
           fmt::format("{:.1e} rad rms, {} of {} lost", schoolbook.rms_rad, schoolbook.missed,
                       schoolbook.n + schoolbook.missed),
           fmt::format("{:.1e} rad, gray {:.1e}", a.worst_phase_rms_rad(), a.gray_rms));
  }
}

auto around(const Twin& twin, const Vector3d& point, int side, int stride) {
  return [=](std::size_t camera) { return block_around(twin, camera, point, side, stride); };
}
auto everywhere(const Twin& twin, int stride) {
  return [=](std::size_t camera) { return whole_image(twin, camera, stride); };
}

TEST(HardSpheres, TenthOfAMillimetreUnderAMacroLens) {
  REQUIRE_RENDERER();
  const Vector3d center(3.0, -2.0, 250.0);
  const Twin twin =
      with_object(zoomed(paper_rig(), center, 50.0, 240, 240), "grain", SphereShape{center, 0.1});
  expect_sphere("sphere R 0.1 mm at 250 mm, macro lens", twin, everywhere(twin, 5));
}

TEST(HardSpheres, OneMetreAndTenMetres) {
  REQUIRE_RENDERER();
  for (const double r : {1e3, 1e4}) {
    const Twin twin = with_object(paper_rig(), "ball", SphereShape{{0, 0, 250 + r}, r});
    expect_sphere(fmt::format("sphere R {} m, nearest point at 250 mm", r / 1e3), twin, everywhere(twin, 47));
  }
  const Vector3d n = Vector3d(0.35, -0.25, 0.9).normalized();
  const Twin tilted = with_object(paper_rig(), "ball", SphereShape{Vector3d(0, 0, 280) + 1e4 * n, 1e4});
  expect_sphere("sphere R 10 m, centre 4 m off the axis", tilted, everywhere(tilted, 47));
}

// The same rig built 50 times smaller ... 2000 times larger: the figures stay.
TEST(HardSpheres, ScaledRigs) {
  REQUIRE_RENDERER();
  for (const double k : {0.02, 40.0, 2000.0}) {
    const Vector3d center(0, 0, 250 * k);
    const Twin twin = with_object(scaled(paper_rig(), k), "ball", SphereShape{center, 5 * k});
    expect_sphere(fmt::format("rig and sphere x {}: R {} mm", k, 5 * k), twin, around(twin, center, 120, 5));
  }
}

TEST(HardSpheres, TenMetresWithDepthOfField) {
  REQUIRE_RENDERER();
  Twin twin = with_object(only_camera(paper_rig(), 0), "ball", SphereShape{{0, 0, 10250}, 1e4});
  twin.cameras[0].optics = Optics{4.0, 12.0, 260.0};
  twin.cameras[0] = crop(twin.cameras[0], 500, 400, 320, 240);
  expect_sphere("sphere R 10 m, lens f/4", twin, everywhere(twin, 27));
}

// A ball of 19 mm seen from 10 m through long lenses: 40,000 px of projector focal length make the
// single-precision floor 8e-4 rad, so the renderer takes double precision by itself.
TEST(HardSpheres, BallTenMetresAway) {
  REQUIRE_RENDERER();
  Twin twin = bench_rig(6e4, 320, 240, 1000.0);
  const double turn = std::atan2(1000.0, 1e4);
  Projector& p = *twin.projector;
  p.lens = Lens("LENSMODEL_PINHOLE", {4e4, 4e4, 639.5, 359.5}, {1280, 720}, "projector");
  const Eigen::Matrix3d R = rotation_from_vector({0.0, turn, 0.0});
  p.T_proj_world = {R, -R * Vector3d(1000.0, 0, 0)};
  twin = with_object(twin, "ball", SphereShape{{1.0, -2.0, 1e4}, 19.0});
  Twin single = twin;
  single.render.phase_error_rad = 0.01;
  expect_sphere("ball R 19 mm at 10 m, single precision", single, everywhere(twin, 9), {4e-3, 1e-3});
  expect_sphere("ball R 19 mm at 10 m, default", twin, everywhere(twin, 9), {1e-4, 5e-5});
}

TEST(HardSpheres, WorldOriginTenMetresOff) {
  REQUIRE_RENDERER();
  const Twin near = with_object(only_camera(paper_rig(), 1), "ball", ideal_sphere());
  const Twin far = moved(near, random_pose(3, {7000.0, -5000.0, 4000.0}));
  const auto a = shared_renderer()->render(near, 0, render::choose_sampling(near));
  const auto b = shared_renderer()->render(far, 0, render::choose_sampling(far));
  double worst = 0.0;
  int different = 0, lit = 0;
  const render::Reference reference(near);
  const auto truth =
      reference_block(reference, 0, block_around(near, 0, {0, 0, 250}, 110, 2), {.gauss_n = 2}, true);
  for (const auto& p : truth)
    for (std::size_t i = 0; i < a.irradiance.size(); ++i, ++lit) {
      const double d = std::abs(a.irradiance[i](p.x, p.y) - b.irradiance[i](p.x, p.y));
      worst = std::max(worst, d / near.projector->intensity);
      different += d > 0.0;
    }
  report("world origin 10 m off", "",
         fmt::format("{} of {} values differ, by at most {:.1e}", different, lit, worst));
  EXPECT_GT(truth.size(), 500u);
  EXPECT_LE(worst, 1e-4);
  expect_sphere("sphere R 5 mm, world origin 10 m off", far,
                around(far, std::get<SphereShape>(far.objects[0].shape).center_mm, 120, 5));
}

}  // namespace
}  // namespace fringetwin::testing::spheres_test
