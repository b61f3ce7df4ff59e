// SPDX-License-Identifier: Apache-2.0
// Lenses at the limit of their invertibility, light that a folding projector model would throw where
// there is none, the border of the projected image.
// | tolerance | unit           | origin                                                              |
// |-----------|----------------|---------------------------------------------------------------------|
// | 4e-5      | rad rms        | required; image corner at 90 % of the lens's largest radius            |
// | 1e-3      | rad rms        | at 99 %: the slope of the inverse grows without bound; there is a warning |
// |           |                | at 99.9 %: refused                                                     |
// | 0         | pixels         | light from beyond the invertible radius                              |
// | 2e-3      | px             | border of the projected image along a row: 1024 samples in a pixel   |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/hard_support.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::lenses_test {
namespace {

using Eigen::Vector3d;

// Barrel distortion k1 = -0.3: r (1 - 0.3 r^2) has its maximum 0.7027 at r = 1.0541, 46.5 degrees.
constexpr double k1 = -0.3;
const double r_max = 1.0 / std::sqrt(-3.0 * k1), distorted_max = r_max * (1.0 + k1 * r_max * r_max);

/// A camera of 321 x 241 px whose corner lies at `share` of the largest distorted radius.
Lens lens_near_its_limit(double share) {
  const double f = std::hypot(160.5, 120.5) / (share * distorted_max);
  return Lens("LENSMODEL_OPENCV4", {f, f, 160.0, 120.0, k1, 0, 0, 0}, {321, 241}, "near its limit");
}

/// Five fixed-point steps, as textbooks and many programs undistort.
Vector3d schoolbook_unproject(const Lens& lens, const Eigen::Vector2d& q) {
  const auto& k = lens.intrinsics();
  const Eigen::Vector2d target((q.x() - k[2]) / k[0], (q.y() - k[3]) / k[1]);
  Eigen::Vector2d a = target;
  for (int i = 0; i < 5; ++i) a = target / (1.0 + k1 * a.squaredNorm());
  return Vector3d(a.x(), a.y(), 1.0).normalized();
}

TEST(HardLenses, CameraAtItsLimit) {
  REQUIRE_RENDERER();
  for (const double share : {0.9, 0.99}) {
    Twin twin = bench_rig();
    twin.cameras[0].lens = lens_near_its_limit(share);
    // a wide projector: the corner is 46 degrees off the axis
    twin.projector->lens = Lens("LENSMODEL_PINHOLE", {450, 450, 639.5, 499.5}, {1280, 1000}, "projector");
    twin = with_object(twin, "plane", frontal_plane(300.0));
    const PixelBlock corner{281, 201, 40, 40, 1};
    render::Renderer renderer;  // a new one: warnings come once per lens
    ::testing::internal::CaptureStderr();
    renderer.trace(twin, 0, {Sampler::gauss, 1});
    const std::string warning = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(warning.find("interpolated to") != std::string::npos, share > 0.9) << warning;
    const Agreement a = agreement(twin, 0, {Sampler::gauss, 4}, corner, Pixels::interior);
    const Agreement b = agreement(twin, 0, {Sampler::gauss, 16}, corner, Pixels::interior, {.gauss_n = 16});
    double schoolbook = 0.0;
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector2d q(281 + i, 201 + i);
      const Vector3d s = schoolbook_unproject(twin.cameras[0].lens, q),
                     truth = *twin.cameras[0].lens.unproject(q);
      schoolbook = std::max(schoolbook, std::acos(std::min(1.0, s.dot(truth))));
    }
    report(fmt::format("camera corner at {} of the largest radius", share),
           fmt::format("5 fixed-point steps: ray off by up to {:.1e} rad", schoolbook),
           fmt::format("{:.1e} rad, max {:.1e}; 16 samples {:.1e}; {}", a.worst_phase_rms_rad(),
                       a.pitches[0].phase_max_rad, b.worst_phase_rms_rad(),
                       warning.substr(0, warning.find(','))));
    EXPECT_GT(a.n, 500);
    EXPECT_LE(b.worst_phase_rms_rad(), share > 0.9 ? 1e-3 : 4e-5);
    EXPECT_LE(b.gray_rms, share > 0.9 ? 1e-3 : 5e-5);
  }
}

TEST(HardLenses, CameraTooNearItsLimit) {
  REQUIRE_RENDERER();
  Twin twin = with_object(bench_rig(), "plane", frontal_plane(300.0));
  twin.cameras[0].lens = lens_near_its_limit(0.999);
  EXPECT_THROW(shared_renderer()->trace(twin, 0, {Sampler::gauss, 1}), UserError);
}

// The polynomial folds: points far outside come back into the image. They get no light.
TEST(HardLenses, ProjectorThatFolds) {
  REQUIRE_RENDERER();
  Twin twin = bench_rig(120.0, 321, 241, 40.0);  // a wide camera: 53 degrees to the sides
  const double f = std::hypot(320.5, 240.5) / (0.8 * distorted_max);
  twin.projector->lens = Lens("LENSMODEL_OPENCV4", {f, f, 320, 240, k1, 0, 0, 0}, {641, 481}, "folding");
  twin = with_object(twin, "plane", frontal_plane(300.0));
  const auto t = shared_renderer()->trace(twin, 0, {Sampler::gauss, 1});
  const render::Reference reference(twin);
  const auto& k = twin.projector->lens.intrinsics();
  int ghosts = 0, wrong = 0, lit = 0;
  for (int y = 0; y < 241; ++y)
    for (int x = 0; x < 321; ++x) {
      const auto s = reference.sample(0, {x, y});
      const Vector3d p = twin.projector->T_proj_world * s.point_world_mm;
      const Eigen::Vector2d a(p.x() / p.z(), p.y() / p.z());
      const Eigen::Vector2d q = f * a * (1.0 + k1 * a.squaredNorm()) + Eigen::Vector2d(k[2], k[3]);
      const bool inside = q.x() > -0.5 && q.y() > -0.5 && q.x() < 640.5 && q.y() < 480.5;
      lit += s.lit;
      ghosts += inside && !s.lit;
      wrong += (t.mean(x, y) > 0.0F) != s.lit;
    }
  report(fmt::format("projector model that folds back, {} lit pixels", lit),
         fmt::format("{} pixels get light that is not there", ghosts), fmt::format("{} wrong pixels", wrong));
  EXPECT_GT(ghosts, 1000);
  EXPECT_EQ(wrong, 0);
}

// Left border of the projected image on a frontal plane: x = 40 + 300 (-0.5 - 639.5)/1700 mm, at a known
// column of the camera. The light along a row, added up, places it.
TEST(HardLenses, BorderOfTheProjectedImage) {
  REQUIRE_RENDERER();
  Twin twin = bench_rig(600.0, 401, 41, 40.0);
  twin = with_object(twin, "plane", frontal_plane(300.0));
  const double border = 200.0 + 600.0 / 300.0 * (40.0 - 300.0 * 640.0 / 1700.0);
  const auto t = shared_renderer()->trace(twin, 0, {Sampler::multi_jittered, 1024});
  const int inside = static_cast<int>(border) + 3;
  double worst = 0.0;
  for (int y = 0; y < 41; ++y) {
    // w changes by some 1e-4 a pixel: extrapolated from two pixels inside
    double found = inside + 0.5;
    for (int x = inside; x >= inside - 6; --x) {
      const double slope = t.mean(inside + 1, y) - t.mean(inside, y);
      const double full = t.mean(inside, y) + slope * (x - inside);
      found -= t.mean(x, y) / full;
    }
    worst = std::max(worst, std::abs(found - border));
  }
  // decided by the pixel's centre alone
  const double schoolbook = std::abs(std::ceil(border) - 0.5 - border);
  report("border of the projected image", fmt::format("one ray: {:.2f} px", schoolbook),
         fmt::format("{:.1e} px at worst", worst));
  EXPECT_LE(worst, 2e-3);
  // and against the reference on the same 16 x 16 points
  const Agreement a =
      agreement(twin, 0, {Sampler::gauss, 256}, {inside - 8, 0, 12, 41, 1}, Pixels::all, {.gauss_n = 16});
  EXPECT_LE(a.gray_max, 1e-5);
}

}  // namespace
}  // namespace fringetwin::testing::lenses_test
