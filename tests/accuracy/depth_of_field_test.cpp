// SPDX-License-Identifier: Apache-2.0
// Depth of field: the default lens rule against the reference's 12 rings x 36 spokes.
// | tolerance    | unit           | origin                                                           |
// |--------------|----------------|------------------------------------------------------------------|
// | 4e-5 / c     | rad rms        | as for the shapes, c the contrast the defocus leaves               |
// | 6e-6         | full scale rms | the lens rule's 1e-6 of the fringes, and single precision's 2e-6   |
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iostream>
#include <numbers>

#include "tests/support/expect_agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::testing::depth_of_field_test {
namespace {

constexpr double kDefocusLimit = 6e-6;

Twin plane_window(int width, int height) {
  return with_object(left_window({0, 0, 300}, width, height), "plane", frontal_plane());
}

double change(const Twin& a, const Twin& b) {
  return relative_change(shared_renderer()->render(a, 0, render::choose_sampling(a)),
                         shared_renderer()->render(b, 0, render::choose_sampling(b)));
}

// Fringes that lose most of their contrast: the swing from the middle of the lens to its rim is that of
// the finest pitch. Phase errors grow as the contrast 2 J1(s)/s falls; so does their limit.
void expect_defocus_agreement(const Twin& twin, const std::string& what, double contrast, int stride) {
  const render::ReferenceQuadrature fine{.gauss_n = 4, .lens_rings = 12, .lens_spokes = 36};
  const Agreement a =
      agreement(twin, 0, render::choose_sampling(twin), whole_image(twin, 0, stride), Pixels::interior, fine);
  std::cout << what << ": " << a.text() << "\n";
  EXPECT_GE(a.n, 25) << what;
  EXPECT_LE(a.worst_phase_rms_rad(), kPhaseLimit_rad / contrast) << what;
  EXPECT_LE(a.gray_rms, kDefocusLimit) << what;
}

double swing_rad(double lens_radius_mm, double z_mm, double focus_mm) {
  return 2 * std::numbers::pi / 13 * 1700 * lens_radius_mm * std::abs(1 / z_mm - 1 / focus_mm);
}
double contrast_at(double swing) { return std::abs(2 * std::cyl_bessel_j(1, swing) / swing); }

TEST(DepthOfField, OfThePapersLens) {
  REQUIRE_RENDERER();
  Twin twin = plane_window(80, 60);
  const Twin pinhole = twin;
  twin.cameras[0].optics = Optics{8.0, 10.0, 270.0};  // the paper's lens, focused 30 mm before the plane
  expect_defocus_agreement(twin, "f/8", 1.0, 7);
  twin.cameras[0].optics = Optics{1.4, 10.0, 270.0};
  expect_defocus_agreement(twin, "f/1.4", 1.0, 7);
  EXPECT_GT(change(pinhole, twin), 1e-3);
  twin.cameras[0].optics = Optics{1e6, 10.0, 270.0};  // a lens of 10 nm
  EXPECT_LT(change(pinhole, twin), 1e-4);
}

TEST(DepthOfField, FarOutOfFocus) {
  REQUIRE_RENDERER();
  for (const double swing : {1.5, 2.5, 3.2}) {
    Twin twin = plane_window(80, 60);
    const double radius = swing / swing_rad(1.0, 300, 250);
    twin.cameras[0].optics = Optics{10.0 / (2 * radius), 10.0, 250.0};
    expect_defocus_agreement(twin, "swing of " + std::to_string(swing) + " rad", contrast_at(swing), 11);
  }
}

// The lens is sampled for what is in view, not for the bounded shapes alone: a sphere in focus, a plane
// far behind.
TEST(DepthOfField, BehindAnObjectInFocus) {
  REQUIRE_RENDERER();
  Twin twin = with_object(left_window({0, 0, 250}, 160, 120), "sphere", ideal_sphere());
  twin = with_object(twin, "plane", frontal_plane(400));
  twin.cameras[0].optics = Optics{2.0, 10.0, 250.0};
  expect_defocus_agreement(twin, "sphere in focus, plane behind", contrast_at(swing_rad(2.5, 400, 250)), 11);
}

// Nor for the point that happens to name a plane: here it lies as far away as the focus.
TEST(DepthOfField, OfAPlaneNamedByAFarPoint) {
  REQUIRE_RENDERER();
  Twin twin = plane_window(80, 60);
  std::get<PlaneShape>(twin.objects[0].shape).point_mm = {150, 0, 200};
  twin.cameras[0].optics = Optics{2.0, 10.0, 250.0};
  expect_defocus_agreement(twin, "plane named by a far point", contrast_at(swing_rad(2.5, 200, 250)), 11);
}

TEST(DepthOfField, OnASphere) {
  REQUIRE_RENDERER();
  Twin twin = with_object(left_window(physical_sphere().center_mm, 120, 90), "sphere", physical_sphere());
  twin.cameras[0].optics = Optics{2.0, 10.0, 270.0};
  expect_defocus_agreement(twin, "f/2, sphere", 1.0, 9);
}

}  // namespace
}  // namespace fringetwin::testing::depth_of_field_test
