// SPDX-License-Identifier: Apache-2.0
// Tests of the tests' power: half a pixel and a flipped sign anywhere must fail by orders of magnitude.
// | bound     | unit    | origin                                                                    |
// |-----------|---------|---------------------------------------------------------------------------|
// | 4e-5      | rad rms | the agreement that the right convention reaches (shapes_test.cpp)          |
// | > 1e-2    | rad     | half a pixel is 0.5 * 2 pi / 15 = 0.2 rad of the projector                  |
// | 1e-5      | rad     | hand-computed phase of a pinhole plane, fp32                                |
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::conventions_test {
namespace {

constexpr double pi = std::numbers::pi;

Twin window() { return with_object(left_window({0, 0, 300}, 160, 120), "plane", tilted_plane()); }
Lens shifted(const Lens& lens, double dx, double dy) {
  std::vector<double> intrinsics = lens.intrinsics();
  intrinsics[2] += dx;
  intrinsics[3] += dy;
  return Lens(lens.model(), intrinsics, {lens.width(), lens.height()}, "shifted lens");
}
/// `twin` rendered, against the reference of `other`.
Agreement against(const Twin& twin, const Twin& other) {
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  const render::Reference reference(other);
  return compare(twin, 0, rendered.irradiance, reference_block(reference, 0, whole_image(twin, 0, 7)));
}

TEST(Conventions, TheRightOneAgrees) {
  REQUIRE_RENDERER();
  EXPECT_LE(against(window(), window()).worst_phase_rms_rad(), 4e-5);
}

TEST(Conventions, HalfAPixelOfTheCameraShows) {
  REQUIRE_RENDERER();
  Twin off = window();
  off.cameras[0].lens = shifted(off.cameras[0].lens, 0.5, 0.0);
  EXPECT_GT(against(window(), off).worst_phase_rms_rad(), 1e-2);
  off = window();
  off.cameras[0].lens = shifted(off.cameras[0].lens, 0.0, 0.5);
  EXPECT_GT(against(window(), off).worst_phase_rms_rad(), 5e-4);  // along the fringes little happens
}

TEST(Conventions, HalfAPixelOfTheProjectorShows) {
  REQUIRE_RENDERER();
  Twin off = window();
  off.projector->lens = shifted(off.projector->lens, 0.5, 0.0);
  const Agreement a = against(window(), off);
  for (std::size_t p = 0; p < 3; ++p)
    EXPECT_NEAR(std::abs(a.pitches[p].phase_mean_rad), 2 * pi * 0.5 / (13.0 + static_cast<double>(p)), 1e-3);
}

// Reversing the steps conjugates the phase: nothing agrees any more.
TEST(Conventions, AFlippedStepSignShows) {
  REQUIRE_RENDERER();
  const Twin twin = window();
  auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  for (std::size_t p = 0; p < 3; ++p)
    std::swap(rendered.irradiance[4 * p + 1], rendered.irradiance[4 * p + 3]);
  const render::Reference reference(twin);
  const Agreement a =
      compare(twin, 0, rendered.irradiance, reference_block(reference, 0, whole_image(twin, 0, 7)));
  EXPECT_GT(a.worst_phase_rms_rad(), 1.0);
}

// No reference code at all: one camera pixel, one plane, the phase by hand (docs/CONVENTIONS.md, "Fringes").
TEST(Conventions, PhaseOfAPinholePlaneByHand) {
  REQUIRE_RENDERER();
  Twin twin = paper_rig();
  twin.cameras = {
      {"cam", Lens("LENSMODEL_PINHOLE", {1000, 1000, 31.0, 23.0}, {64, 48}, "pinhole"), {}, {}, {}}};
  twin.projector->lens = Lens("LENSMODEL_PINHOLE", {800, 800, 319.5, 239.5}, {640, 480}, "pinhole");
  twin.projector->T_proj_world = {Eigen::Matrix3d::Identity(), {-80.0, 0.0, 0.0}};
  twin.fringes.directions[0].phase_origin_px = {0.0, 2.0, -0.5};
  twin = with_object(twin, "plane", frontal_plane());
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  for (const auto& [x, y] : {std::pair{31, 23}, {0, 0}, {63, 47}, {20, 40}}) {
    const double column = 800 * (0.3 * (x - 31.0) - 80) / 300 + 319.5;
    for (std::size_t p = 0; p < 3; ++p) {
      const double pitch = 13.0 + static_cast<double>(p);
      const double theta = 2 * pi * (column - twin.fringes.directions[0].phase_origin_px[p]) / pitch;
      const double measured = stepped_phase(4, [&, x = x, y = y](int n) {
        return rendered.irradiance[4 * p + static_cast<std::size_t>(n)](x, y);
      });
      // the pixel's average weight slopes: its phase effect is (2 pi 0.8/pitch) (dw/dx)/w / 12 = 2e-5 rad
      EXPECT_NEAR(wrap(measured - theta), 0.0, 6e-5) << x << " " << y << " pitch " << pitch;
    }
  }
}

// The same scene in another world frame gives the same images: poses are applied the right way round.
TEST(Conventions, TheWorldFrameIsArbitrary) {
  REQUIRE_RENDERER();
  Twin twin = left_window({0, 0, 250}, 120, 90);
  Twin moved = twin;
  const Pose T_new_world{rotation_from_vector({0.7, -0.4, 1.9}), {120.0, -80.0, 40.0}};
  for (Camera& c : moved.cameras) c.T_cam_world = c.T_cam_world * T_new_world.inverse();
  moved.projector->T_proj_world = moved.projector->T_proj_world * T_new_world.inverse();
  const SphereShape sphere = ideal_sphere();
  twin = with_object(twin, "sphere", sphere);
  moved = with_object(moved, "sphere", SphereShape{T_new_world * sphere.center_mm, sphere.radius_mm});
  const Agreement a = against(moved, twin);
  EXPECT_GT(a.n, 50);
  EXPECT_LE(a.worst_phase_rms_rad(), 4e-5);
}

}  // namespace
}  // namespace fringetwin::testing::conventions_test
