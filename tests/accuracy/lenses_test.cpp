// SPDX-License-Identifier: Apache-2.0
// Lens models of cameras and projectors, each path of the shaders.
// | tolerance | unit           | origin                                                              |
// |-----------|----------------|---------------------------------------------------------------------|
// | 4e-5      | rad rms        | as for the shapes (shapes_test.cpp)                                  |
// | 5e-5      | full scale rms | as for the shapes                                                   |
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/lens/mrcal_facade.hpp"

namespace fringetwin::testing::lenses_test {
namespace {

const std::string spline = "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=8_fov_x_deg=60";
/// The spline deforms by up to 0.2 % of the focal length: 4 px.
std::vector<double> splined(std::vector<double> pinhole) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.002, 0.002);
  for (int i = 0; i < 2 * 11 * 8; ++i) pinhole.push_back(uniform(random));
  return pinhole;
}

std::vector<double> undeformed(std::vector<double> pinhole) {
  pinhole.resize(4 + 2 * 11 * 8, 0.0);
  return pinhole;
}

/// Half width of the spline's knots in u = 2 tan(theta/2).
double spline_reach() { return MrcalModel::from_name(spline)->spline_half_size()->x(); }

Twin plane_window(int width = 240, int height = 180) {
  return with_object(left_window({0, 0, 300}, width, height), "plane", tilted_plane());
}

TEST(Lenses, Cameras) {
  REQUIRE_RENDERER();
  Twin twin = plane_window();
  const std::vector<double> k = twin.cameras[0].lens.intrinsics();
  twin.cameras[0].lens =
      Lens("LENSMODEL_OPENCV8", {k[0], k[1], k[2], k[3], 0.2, -0.1, 3e-4, -2e-4, 0.05, 0.3, -0.1, 0.02},
           {240, 180}, "eight coefficients");
  expect_agreement(twin, "OPENCV8 camera", 1000);
  twin.cameras[0].lens =
      Lens("LENSMODEL_STEREOGRAPHIC", {k[0], k[1], k[2], k[3]}, {240, 180}, "stereographic");
  expect_agreement(twin, "stereographic camera", 1000);
  twin.cameras[0].lens = Lens(spline, splined({k[0], k[1], k[2], k[3]}), {240, 180}, "splined");
  expect_agreement(twin, "splined camera", 1000);
}

/// Coefficients whose last terms move the image's corners by several pixels.
const std::vector<std::pair<std::string, std::vector<double>>>& opencv_lenses() {
  static const std::vector<std::pair<std::string, std::vector<double>>> lenses{
      {"LENSMODEL_OPENCV5", {0.13, -0.3, -6e-4, -1e-4, 0.4}},
      {"LENSMODEL_OPENCV8", {0.2, -0.1, 3e-4, -2e-4, 0.05, 0.3, -0.1, 0.02}},
      {"LENSMODEL_OPENCV12", {0.2, -0.1, 3e-4, -2e-4, 0.05, 0.3, -0.1, 0.02, 4e-3, -2e-3, 3e-3, 1e-3}}};
  return lenses;
}

TEST(Lenses, Projectors) {
  REQUIRE_RENDERER();
  Twin twin = plane_window();
  const std::vector<double> p = twin.projector->lens.intrinsics();
  const std::vector<double> f{p[0], p[1], p[2], p[3]};
  std::vector<std::pair<std::string, std::vector<double>>> lenses = opencv_lenses();
  for (auto& [model, intrinsics] : lenses) intrinsics.insert(intrinsics.begin(), f.begin(), f.end());
  lenses.emplace_back("LENSMODEL_STEREOGRAPHIC", f);
  lenses.emplace_back(spline, splined(f));
  for (const auto& [model, intrinsics] : lenses) {
    twin.projector->lens = Lens(model, intrinsics, {1280, 720}, model);
    expect_agreement(twin, model + " projector", 1000);
  }
}

Lens wide_lens(const std::string& model, std::vector<double> distortion, double focal_px, int width,
               int height) {
  distortion.insert(distortion.begin(), {focal_px, focal_px, 0.5 * width - 0.5, 0.5 * height - 0.5});
  return Lens(model, distortion, {width, height}, model);
}

/// A camera and a projector side by side before a wall; the fringes are as wide as the camera's large pixels
/// need.
Twin wide_rig(const Lens& camera, const Lens& projector) {
  Twin twin = with_object(only_camera(paper_rig(), 0), "wall", frontal_plane(300.0));
  twin.cameras[0].lens = camera;
  twin.projector->lens = projector;
  twin.projector->T_proj_world = Pose{Eigen::Matrix3d::Identity(), {-60.0, 0.0, 0.0}};
  twin.fringes.directions[0].pitches_px = {64.0, 72.0, 80.0};
  return twin;
}

// All of the projected image is seen, out to corners 39 degrees off the axis: r^6 is 0.3 there, so that the
// sign of k6 = 0.02 moves them by 7 px, that of k3 by more.
TEST(Lenses, ProjectorsOutToTheirCorners) {
  REQUIRE_RENDERER();
  for (const auto& [model, distortion] : opencv_lenses())
    expect_agreement(wide_rig(wide_lens("LENSMODEL_PINHOLE", {}, 130.0, 240, 180),
                              wide_lens(model, distortion, 900.0, 1280, 720)),
                     model + " projector to its corners", 600, 5);
}

// The camera's corners lie 37 degrees off its axis, within the light.
TEST(Lenses, CamerasOutToTheirCorners) {
  REQUIRE_RENDERER();
  for (const auto& [model, distortion] : opencv_lenses())
    expect_agreement(wide_rig(wide_lens(model, distortion, 200.0, 240, 180),
                              wide_lens("LENSMODEL_PINHOLE", {}, 600.0, 1280, 720)),
                     model + " camera to its corners", 1700, 5);
}

// The terms the shader reads from their places: each alone changes the phase by far more than the limit.
TEST(Lenses, EveryProjectorCoefficientCounts) {
  REQUIRE_RENDERER();
  Twin twin = plane_window(64, 48);
  twin.cameras[0] =
      crop(only_camera(paper_rig(), 0).cameras[0], 1100, 300, 64, 48);  // off the projector's axis
  const std::vector<double> p = twin.projector->lens.intrinsics();
  std::vector<double> k{p[0], p[1], p[2], p[3], 0.2,  -0.1,  3e-4, -2e-4,
                        0.05, 0.3,  -0.1, 0.02, 4e-3, -2e-3, 3e-3, 1e-3};
  twin.projector->lens = Lens("LENSMODEL_OPENCV12", k, {1280, 720}, "all");
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  for (std::size_t i = 4; i < k.size(); ++i) {
    if (i == 14 || i == 15) continue;  // s3, s4 move rows, along these fringes
    Twin other = twin;
    std::vector<double> changed = k;
    changed[i] += i == 6 || i == 7 || i >= 12 ? 1e-3 : 0.05;
    other.projector->lens = Lens("LENSMODEL_OPENCV12", changed, {1280, 720}, "changed");
    const render::Reference reference(other);
    const Agreement a =
        compare(twin, 0, rendered.irradiance, reference_block(reference, 0, whole_image(twin, 0, 5)));
    EXPECT_GT(a.n, 20);
    EXPECT_GT(a.worst_phase_rms_rad(), 4e-4) << "coefficient " << i - 4;
  }
}

// The projector's image ends where its spline ends: the last pixels are lit, too.
TEST(Lenses, BorderOfASplinedProjector) {
  REQUIRE_RENDERER();
  Twin twin = plane_window(240, 60);
  const double focal_px = 640.0 / (0.9995 * spline_reach());
  const Lens lens(spline, undeformed({focal_px, focal_px, 639.5, 359.5}), {1280, 720}, "splined");
  // Turn the projector until its first column lies in the middle of the view.
  const Eigen::Vector3d middle =
      twin.projector->T_proj_world * render::Reference(twin).sample(0, {120, 30}).point_world_mm;
  const Eigen::Vector3d border = *lens.unproject({-0.5, 359.5});
  const double turn_rad = std::atan2(border.x(), border.z()) - std::atan2(middle.x(), middle.z());
  twin.projector->lens = lens;
  twin.projector->T_proj_world =
      Pose{rotation_from_vector({0, turn_rad, 0}), Eigen::Vector3d::Zero()} * twin.projector->T_proj_world;
  expect_agreement(twin, "border of a splined projector", 300);
  const auto rendered = shared_renderer()->render(twin, 0, render::choose_sampling(twin));
  const render::Reference reference(twin);
  int lit = 0, dark = 0;
  for (int x = 0; x < 240; ++x) {
    const auto p = reference.pixel(0, x, 30, {.gauss_n = 8});
    const double light = rendered.irradiance[0](x, 30) + rendered.irradiance[2](x, 30);
    if (p.mean == 0.0) {
      ++dark;
      EXPECT_EQ(light, 0.0) << x;
    } else if (reference.is_whole(0, x, 30)) {
      ++lit;
      EXPECT_NEAR(light, p.mean, 1e-4 * p.mean) << x;
    }
  }
  EXPECT_GT(lit, 50);
  EXPECT_GT(dark, 50);
}

}  // namespace
}  // namespace fringetwin::testing::lenses_test
