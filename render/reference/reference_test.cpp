// SPDX-License-Identifier: Apache-2.0
// The reference against hand-written closed forms.
// | tolerance    | unit      | origin                                                            |
// |--------------|-----------|-------------------------------------------------------------------|
// | 1e-9         | px, mm    | lens inversion (1e-9 px promised), rounding at 300 mm               |
// | 1e-12        | relative  | rounding of a few dozen operations                                  |
// | 1e-10        | relative  | 8x8 Gauss-Legendre over one pixel against a 400-point Simpson rule  |
#include "render/reference/reference.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::render::reference_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::with_object;
constexpr double pi = std::numbers::pi;

/// One pinhole camera (f 1000, 400x300) at the origin, a pinhole projector (f 800, 640x480) shifted by
/// `projector_mm` and looking along z; fringes of 16 px in 4 steps.
Twin pinhole_rig(const Vector3d& projector_mm = {80.0, 0.0, 0.0}) {
  Twin twin;
  twin.cameras.push_back(
      {"cam", Lens("LENSMODEL_PINHOLE", {1000, 1000, 199.5, 149.5}, {400, 300}, "test"), {}, {}, {}});
  twin.projector.emplace(Projector{Lens("LENSMODEL_PINHOLE", {800, 800, 319.5, 239.5}, {640, 480}, "test"),
                                   {Eigen::Matrix3d::Identity(), -projector_mm},
                                   40.0,
                                   false,
                                   0.0,
                                   0.0,
                                   {},
                                   0.0});
  DirectionFringes d;
  d.pitches_px = {16.0};
  d.phase_origin_px = {3.0};
  twin.fringes.directions = {d};
  return twin;
}
Twin plane_rig(double z_mm = 300.0, const Vector3d& projector_mm = {80.0, 0.0, 0.0}) {
  return with_object(pinhole_rig(projector_mm), "plane", testing::frontal_plane(z_mm));
}
Vector3d plane_point(const Vector2d& q, double z) {
  return {(q.x() - 199.5) / 1000 * z, (q.y() - 149.5) / 1000 * z, z};
}

TEST(ReferencePlane, ProjectorPixelOfAFrontalPlane) {
  const Reference reference(plane_rig());
  for (const Vector2d& q : {Vector2d(199.5, 149.5), {100.0, 20.0}, {250.25, 299.5}}) {
    const PixelSample s = reference.sample(0, q);
    const Vector3d p = plane_point(q, 300.0);
    EXPECT_EQ(s.object, 0);
    EXPECT_TRUE(s.lit);
    EXPECT_NEAR((s.point_world_mm - p).norm(), 0.0, 1e-9);
    EXPECT_NEAR(s.t_mm, p.norm(), 1e-9);
    EXPECT_NEAR(s.projector_px.x(), 800 * (p.x() - 80) / 300 + 319.5, 1e-9);
    EXPECT_NEAR(s.projector_px.y(), 800 * p.y() / 300 + 239.5, 1e-9);
  }
}

TEST(ReferencePlane, LambertAndInverseSquare) {
  Twin twin = plane_rig();
  twin.objects[0].material.diffuse = 0.6;
  const Vector2d q(230.0, 100.0);
  const Vector3d to_projector = Vector3d(80, 0, 0) - plane_point(q, 300.0);
  const double cosine = 300.0 / to_projector.norm();
  EXPECT_NEAR(Reference(twin).sample(0, q).weight, 0.6 / pi * 40 * cosine, 1e-12 * 8);
  twin.projector->inverse_square = true;
  twin.projector->reference_distance_mm = 250.0;
  EXPECT_NEAR(Reference(twin).sample(0, q).weight,
              0.6 / pi * 40 * cosine * std::pow(250.0 / to_projector.norm(), 2), 1e-12 * 8);
}

// Independent of the Gauss rule and of all ray code: Simpson over the closed-form integrand.
TEST(ReferencePlane, PixelMeanEqualsSimpsonOfTheClosedForm) {
  const Twin twin = plane_rig();
  const Reference reference(twin);
  const int x = 170, y = 90, n = 400;
  double mean = 0.0, cosine = 0.0, sine = 0.0;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const auto simpson = [&](int k) { return (k == 0 || k == n ? 1.0 : k % 2 ? 4.0 : 2.0) / (3.0 * n); };
      const Vector3d p =
          plane_point({x - 0.5 + static_cast<double>(i) / n, y - 0.5 + static_cast<double>(j) / n}, 300.0);
      const double w = simpson(i) * simpson(j) * 0.8 / pi * 40 * 300 / (Vector3d(80, 0, 0) - p).norm();
      const double theta = 2 * pi * (800 * (p.x() - 80) / 300 + 319.5 - 3.0) / 16.0;
      mean += w;
      cosine += w * std::cos(theta);
      sine += w * std::sin(theta);
    }
  const ReferencePixel pixel = reference.pixel(0, x, y);
  EXPECT_TRUE(pixel.interior);
  EXPECT_NEAR(pixel.mean, mean, 1e-10 * mean);
  EXPECT_NEAR(pixel.cosine[0][0], cosine, 1e-10 * mean);
  EXPECT_NEAR(pixel.sine[0][0], sine, 1e-10 * mean);
  ASSERT_EQ(pixel.irradiance.size(), 4u);
  for (int step = 0; step < 4; ++step)  // I_n = mean + amplitude cos(theta + 2 pi n/N)
    EXPECT_NEAR(pixel.irradiance[static_cast<std::size_t>(step)],
                0.5 * mean + 0.5 * (cosine * std::cos(pi / 2 * step) - sine * std::sin(pi / 2 * step)),
                1e-10 * mean);
}

TEST(ReferencePlane, PixelFillShrinksTheSquare) {
  Twin twin = plane_rig();
  twin.projector->inverse_square = true;
  twin.projector->reference_distance_mm = 300.0;
  const double full = Reference(twin).pixel(0, 100, 90).cosine[0][0];
  twin.render.pixel_fill = 1e-6;
  const Reference tiny(twin);
  const PixelSample s = tiny.sample(0, {100, 90});
  const double theta = 2 * pi * (s.projector_px.x() - 3) / 16;
  const double at_center = s.weight * std::cos(theta);
  EXPECT_NEAR(tiny.pixel(0, 100, 90).cosine[0][0], at_center, 1e-9 * s.weight);
  // x_projector moves 0.8 px per camera pixel: contrast sinc(fill * 0.8/16)
  twin.render.pixel_fill = 0.5;
  const double half = Reference(twin).pixel(0, 100, 90).cosine[0][0];
  const auto loss = [](double fill) { return std::pow(fill * pi * 0.8 / 16, 2) / 6; };
  EXPECT_NEAR((1 - half / at_center) / (1 - full / at_center), loss(0.5) / loss(1.0), 0.02);
}

TEST(ReferencePlane, TwoSidedAndDarkFromBehind) {
  Twin twin = plane_rig();
  const PixelSample front = Reference(twin).sample(0, {210, 140});
  std::get<PlaneShape>(twin.objects[0].shape).normal *= -1;
  const PixelSample flipped = Reference(twin).sample(0, {210, 140});
  EXPECT_EQ(front.weight, flipped.weight);
  EXPECT_LT(flipped.normal_world.z(), 0.0);
  const PixelSample behind = Reference(plane_rig(300.0, {80.0, 0.0, 310.0})).sample(0, {210, 140});
  EXPECT_EQ(behind.object, 0);
  EXPECT_FALSE(behind.lit);
  EXPECT_EQ(behind.weight, 0.0);
}

TEST(ReferencePlane, NoLightBeyondHalfAPixelOfTheProjectorImage) {
  const Reference reference(plane_rig());
  const auto camera_x = [](double xp) { return ((xp - 319.5) * 300 / 800 + 80) / 300 * 1000 + 199.5; };
  const double inside = camera_x(-0.5 + 1e-6), outside = camera_x(-0.5 - 1e-6);
  EXPECT_TRUE(reference.sample(0, {inside, 150}).lit);
  EXPECT_FALSE(reference.sample(0, {outside, 150}).lit);
  const Reference right(plane_rig(300.0, {-240.0, 0.0, 0.0}));
  const auto camera_x2 = [](double xp) { return ((xp - 319.5) * 300 / 800 - 240) / 300 * 1000 + 199.5; };
  EXPECT_TRUE(right.sample(0, {camera_x2(639.5 - 1e-6), 150}).lit);
  EXPECT_FALSE(right.sample(0, {camera_x2(639.5 + 1e-6), 150}).lit);
}

// k1 = -0.9 folds the image beyond radius sqrt(1/2.7) = 0.61: points outside would come back inside.
TEST(ReferencePlane, NoLightBeyondTheInvertibleRadius) {
  Twin twin = plane_rig(300.0, {200.0, 0.0, 0.0});
  twin.projector->lens = Lens("LENSMODEL_OPENCV4", {400, 400, 99.5, 99.5, -0.9, 0, 0, 0}, {200, 200}, "test");
  const Reference reference(twin);
  for (double x = -30.0; x < 30.0; x += 1.3) {
    const double r = (x - 200) / 300, q = 400 * r * (1 - 0.9 * r * r) + 99.5;
    const bool expected = std::abs(r) < std::sqrt(1 / 2.7) && q > -0.5;
    EXPECT_EQ(reference.sample(0, {x / 300 * 1000 + 199.5, 149.5}).lit, expected) << x;
  }
}

TEST(ReferencePlane, MirrorDirectionOfPhong) {
  Twin twin = plane_rig();
  twin.objects[0].material = {0.0, 0.3, 50.0};
  const Reference reference(twin);
  const Vector2d mirror(40.0 / 300 * 1000 + 199.5, 149.5);  // half way to the projector
  EXPECT_NEAR(reference.sample(0, mirror).weight, 40 * 0.3, 1e-9);
  const Vector3d p(20, 10, 300), L = (Vector3d(80, 0, 0) - p).normalized(), V = (-p).normalized();
  const Vector3d R(-L.x(), -L.y(), L.z());
  EXPECT_NEAR(reference.sample(0, {20.0 / 0.3 + 199.5, 10.0 / 0.3 + 149.5}).weight,
              40 * 0.3 * std::pow(R.dot(V), 50), 1e-9);
}

TEST(ReferenceSphere, CentrePixelOfACoaxialLight) {
  const Twin twin = with_object(pinhole_rig({0, 0, 0}), "ball", SphereShape{{0, 0, 250}, 5.0});
  const PixelSample s = Reference(twin).sample(0, {199.5, 149.5});
  EXPECT_NEAR(s.t_mm, 245.0, 1e-12 * 245);
  EXPECT_NEAR(s.weight, 0.8 / pi * 40, 1e-12 * 11);
  EXPECT_NEAR(s.projector_px.x(), 319.5, 1e-9);
}

TEST(ReferenceSphere, NormalAndPointLieOnTheSphere) {
  const Twin twin = with_object(pinhole_rig(), "ball", SphereShape{{3, -2, 250}, 20.0});
  const Reference reference(twin);
  for (double x = 130; x < 290; x += 7.3)
    for (double y = 70; y < 220; y += 9.1) {
      const PixelSample s = reference.sample(0, {x, y});
      const Vector3d direction = Vector3d((x - 199.5) / 1000, (y - 149.5) / 1000, 1).normalized();
      const double off_axis = Vector3d(3, -2, 250).cross(direction).norm();
      ASSERT_EQ(s.object, off_axis < 20.0 ? 0 : -1);
      if (s.object < 0) continue;
      const Vector3d n = (s.point_world_mm - Vector3d(3, -2, 250)) / 20;
      EXPECT_NEAR(n.norm(), 1.0, 1e-12);
      EXPECT_NEAR((n - s.normal_world).norm(), 0.0, 1e-12);
      EXPECT_LT(n.dot(direction), 0.0);
      EXPECT_EQ(s.lit, n.dot(Vector3d(80, 0, 0) - s.point_world_mm) > 0);
    }
}

TEST(ReferenceShadow, ASphereShadesThePlaneWhereTheSegmentMeetsIt) {
  const Vector3d center(10, 0, 250), light(80, 0, 0);
  Twin twin = with_object(plane_rig(), "ball", SphereShape{center, 5.0});
  const Reference reference(twin);
  int shaded = 0, lit = 0;
  for (double x = 0; x < 400; x += 3.7)
    for (double y = 0; y < 300; y += 3.1) {
      const PixelSample s = reference.sample(0, {x, y});
      if (s.object != 0) continue;
      const Vector3d d = (light - s.point_world_mm).normalized();
      const bool shadow = (center - s.point_world_mm).cross(d).norm() < 5.0;
      const bool in_image = 800 * (s.point_world_mm.x() - 80) / 300 + 319.5 > -0.5;
      EXPECT_EQ(s.lit, !shadow && in_image) << x << " " << y;
      (shadow ? shaded : lit)++;
    }
  EXPECT_GT(shaded, 50);
  EXPECT_GT(lit, 1000);
}

// Something behind the projector or behind the surface casts no shadow.
TEST(ReferenceShadow, OnlyBetweenSurfaceAndProjector) {
  Twin twin = plane_rig();
  const Vector2d q(210, 140);
  const double free = Reference(twin).sample(0, q).weight;
  EXPECT_GT(free, 0.0);
  const Vector3d p = plane_point(q, 300.0), light(80, 0, 0), along = (light - p).normalized();
  twin.objects.push_back({"behind the projector", SphereShape{light + 6 * along, 5.0}, {}});
  twin.objects.push_back({"behind the plane", SphereShape{p - 6 * along, 0.5}, {}});
  EXPECT_EQ(Reference(twin).sample(0, q).weight, free);
  twin.objects.push_back({"between", SphereShape{p + 0.01 * along, 1e-3}, {}});
  EXPECT_EQ(Reference(twin).sample(0, q).weight, 0.0);
}

TEST(ReferenceCylinder, HitNormalAndLimits) {
  CylinderShape cylinder{{0, 0, 250}, Vector3d::UnitY(), 10.0, {}};
  const Twin twin = with_object(pinhole_rig(), "rod", cylinder);
  const Reference reference(twin);
  const PixelSample s = reference.sample(0, {199.5, 149.5});
  EXPECT_NEAR(s.point_world_mm.z(), 240.0, 1e-9);
  for (double x = 165; x < 235; x += 3.3)
    for (double y : {0.0, 140.0, 299.0}) {
      const PixelSample p = reference.sample(0, {x, y});
      ASSERT_EQ(p.object, 0);
      const Vector3d radial(p.point_world_mm.x(), 0, p.point_world_mm.z() - 250);
      EXPECT_NEAR(radial.norm(), 10.0, 1e-11);
      EXPECT_NEAR((p.normal_world - radial / 10).norm(), 0.0, 1e-11);
    }
  cylinder.length_mm = 30.0;
  const Reference finite(with_object(pinhole_rig(), "rod", cylinder));
  const auto y_at = [](double y_mm) { return y_mm / 240 * 1000 + 149.5; };
  EXPECT_EQ(finite.sample(0, {199.5, y_at(14.999)}).object, 0);
  // just above the rim the ray passes over the near wall; the far wall's rim lies at 15/260
  EXPECT_EQ(finite.sample(0, {199.5, y_at(15.001)}).object, -1);
}

// An open tube seen from within (axis along z): its wall faces the viewer, and its own far wall
// shades it from a light outside.
TEST(ReferenceCylinder, SeenFromWithin) {
  const CylinderShape tube{{0, 0, 300}, Vector3d::UnitZ(), 30.0, 40.0};
  const Vector2d q(199.5 + 100, 149.5);  // x/z = 0.1 meets x = 30 at z = 300
  const PixelSample s = Reference(with_object(pinhole_rig({0, 0, 0}), "tube", tube)).sample(0, q);
  EXPECT_EQ(s.object, 0);
  EXPECT_NEAR((s.normal_world - Vector3d(-1, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_TRUE(s.lit);  // through the open end
  Twin outside = with_object(pinhole_rig({-400, 0, 290}), "tube", tube);
  outside.projector->T_proj_world = {rotation_from_vector({0, -pi / 2, 0}), Vector3d::Zero()};
  outside.projector->T_proj_world.translation_mm =
      -(outside.projector->T_proj_world.rotation * Vector3d(-400, 0, 290));
  EXPECT_FALSE(Reference(outside).sample(0, q).lit);
  std::get<CylinderShape>(outside.objects[0].shape).length_mm =
      10.0;  // light passes the short tube's end? no: z 295...305
  std::get<CylinderShape>(outside.objects[0].shape).point_mm.z() = 304.5;
  const PixelSample past =
      Reference(outside).sample(0, q);  // wall 299.5...309.5; the ray crosses x = -30 at z 298.6
  EXPECT_TRUE(past.lit);
}

TEST(ReferencePlane, RectangleHasItsSize) {
  PlaneShape plane = testing::frontal_plane();
  plane.size_mm = Vector2d(20.0, 10.0);
  const Reference reference(with_object(pinhole_rig(), "tile", plane));
  const auto q = [](double x, double y) { return Vector2d(x / 0.3 + 199.5, y / 0.3 + 149.5); };
  EXPECT_EQ(reference.sample(0, q(9.99, 4.99)).object, 0);
  EXPECT_EQ(reference.sample(0, q(-10.01, 0)).object, -1);
  EXPECT_EQ(reference.sample(0, q(0, 5.01)).object, -1);
}

TEST(ReferenceOptics, RaysOfAFocusedPixelMeet) {
  Twin twin = plane_rig();
  twin.cameras[0].optics = Optics{2.0, 16.0, 300.0};
  const Reference reference(twin);
  const PixelSample chief = reference.sample(0, {250, 70});
  for (const Vector2d& uv : {Vector2d(1, 0), {-0.6, 0.8}, {0, -0.5}})
    EXPECT_NEAR((reference.sample(0, {250, 70}, uv).point_world_mm - chief.point_world_mm).norm(), 0.0, 1e-9);
}

TEST(ReferenceOptics, DefocusDiskGrowsWithTheDistanceFromFocus) {
  Twin twin = plane_rig(330.0);
  twin.cameras[0].optics = Optics{2.0, 16.0, 300.0};
  const Reference reference(twin);
  const PixelSample chief = reference.sample(0, {250, 70});
  const Vector2d uv(0.6, -0.8);
  // lens radius 16/(2*2) = 4 mm; at z the rays are spread by (1 - z/focus)
  const Vector3d expected = chief.point_world_mm + 4.0 * (1 - 330.0 / 300.0) * Vector3d(uv.x(), uv.y(), 0);
  EXPECT_NEAR((reference.sample(0, {250, 70}, uv).point_world_mm - expected).norm(), 0.0, 1e-9);
}

// A uniform disk of radius r (projector px) multiplies the fringe by 2 J1(k r)/(k r), k = 2 pi/pitch.
TEST(ReferenceOptics, DefocusLowersTheContrastLikeABesselFunction) {
  Twin twin = plane_rig(330.0);
  const double sharp = std::hypot(Reference(twin).pixel(0, 210, 140).cosine[0][0],
                                  Reference(twin).pixel(0, 210, 140).sine[0][0]);
  twin.cameras[0].optics = Optics{2.0, 16.0, 300.0};
  const ReferencePixel blurred =
      Reference(twin).pixel(0, 210, 140, {.gauss_n = 4, .lens_rings = 8, .lens_spokes = 24});
  const double kr = 2 * pi / 16 * 0.4 * 800 / 330;
  EXPECT_NEAR(std::hypot(blurred.cosine[0][0], blurred.sine[0][0]) / sharp,
              2 * std::cyl_bessel_j(1.0, kr) / kr, 1e-5);
}

TEST(ReferencePixelTest, AmbientIsAddedWhereAnObjectIsHit) {
  Twin twin = with_object(pinhole_rig(), "ball", SphereShape{{0, 0, 250}, 5.0});
  twin.projector->ambient = 0.7;
  const Reference reference(twin);
  EXPECT_NEAR(reference.pixel(0, 199, 149).ambient, 0.7, 1e-12);
  const ReferencePixel nothing = reference.pixel(0, 20, 20);
  EXPECT_EQ(nothing.object, -1);
  EXPECT_EQ(nothing.ambient, 0.0);
  EXPECT_EQ(nothing.irradiance[0], 0.0);
}

TEST(ReferenceBlock, InteriorIsErodedByOnePixel) {
  const Twin twin = with_object(pinhole_rig(), "ball", SphereShape{{0, 0, 250}, 5.0});
  const Reference reference(twin);
  const auto pixels = testing::reference_block(reference, 0, {175, 125, 50, 50, 1}, {.gauss_n = 1});
  ASSERT_EQ(pixels.size(), 2500u);
  int whole = 0, interior = 0;
  for (const testing::ReferenceBlockPixel& p : pixels) {
    whole += p.pixel.interior;
    interior += p.interior;
    bool expected = true;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) expected = expected && reference.is_whole(0, p.x + dx, p.y + dy);
    EXPECT_EQ(p.interior, expected);
  }
  EXPECT_GT(interior, 800);
  EXPECT_LT(interior, whole);
  EXPECT_LT(whole, pi * 20.1 * 20.1);  // silhouette radius 1000 * 5/250 px
}

TEST(ReferenceBlock, BlocksAreClippedAndStrided) {
  const Reference reference(plane_rig());
  const auto pixels = testing::reference_block(reference, 0, {390, 290, 30, 30, 5}, {.gauss_n = 1});
  ASSERT_EQ(pixels.size(), 4u);
  EXPECT_EQ(pixels[3].x, 395);
  EXPECT_EQ(pixels[3].y, 295);
}

}  // namespace
}  // namespace fringetwin::render::reference_test
