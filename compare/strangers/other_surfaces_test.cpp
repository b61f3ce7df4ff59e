// SPDX-License-Identifier: Apache-2.0
// A square in which the real images show another place than the twin is found, counted and named; what wrong
// fringe orders, outlines and another description of the fringes make is not. All counts follow from the size
// of what is planted, all distances from the planes that the points are put on.
#include "compare/strangers/other_surfaces.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "compare/comparison.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::other_surfaces_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using testing::SyntheticSides;

constexpr double kWall_mm = 300.0, kNearer_mm = 30.0;
constexpr double kPitch_px = 13.0;             ///< the finest one of the fringes
constexpr double kOther_px = 1.6 * kPitch_px;  ///< more than half a period, and no whole one
constexpr int kLeft = 60, kTop = 50;           ///< px: of the squares, within the lit disc

struct Square {
  int width = 20, height = 20, left = kLeft, top = kTop;
};

Eigen::Vector3d at_depth(const Lens& lens, int x, int y, double z_mm) {
  const Eigen::Vector3d ray = *lens.unproject({x, y});
  return ray / ray.z() * z_mm;
}

/// Puts a point on a plane across the camera's axis for every pixel that the side measured.
void put_wall(const Twin& twin, Side& side) {
  measure::PointCloud& cloud = side.measurement->cloud;
  cloud = {};
  const measure::CameraDecode& decode = side.measurement->cameras[0];
  for (int y = 0; y < decode.height(); ++y)
    for (int x = 0; x < decode.width(); ++x) {
      if (decode.flags(x, y) != measure::kValid) continue;
      cloud.p_world_mm.push_back(at_depth(twin.cameras[0].lens, x, y, kWall_mm));
      cloud.normal_world.emplace_back(0.0F, 0.0F, -1.0F);
      cloud.q_cam_px.emplace_back(static_cast<float>(x), static_cast<float>(y));
      cloud.sigma_mm.push_back(0.02F);
    }
}

PlaneShape plane_at(double z_mm) {
  PlaneShape plane;
  plane.point_mm = {0.0, 0.0, z_mm};
  return plane;
}

/// One camera and a projector before a wall, as the twin says.
SyntheticSides scene(const testing::SidesTruth& truth = {}) {
  SyntheticSides s = testing::make_sides(truth);
  s.twin.objects = {{"wall", plane_at(kWall_mm), {}}};
  s.twin.measure.fits.clear();
  s.twin.measure.triangulate = Triangulate::projector;
  for (Side* side : {&s.real, &s.simulated}) {
    put_wall(s.twin, *side);
    side->measurement->fits.clear();
  }
  return s;
}

/// Moves a side's fringes and points in a rectangle.
void plant(const SyntheticSides& s, Side& side, double by_px, double z_mm, const Square& square = {}) {
  measure::CameraDecode& decode = side.measurement->cameras[0];
  measure::PointCloud& cloud = side.measurement->cloud;
  const Image<int> index = measure::point_grid(cloud, decode.width(), decode.height());
  for (int y = square.top; y < square.top + square.height; ++y)
    for (int x = square.left; x < square.left + square.width; ++x) {
      ASSERT_EQ(decode.flags(x, y), measure::kValid);
      decode.directions[0].coordinate_px(x, y) += by_px;
      if (index(x, y) >= 0) cloud.p_world_mm[index(x, y)] = at_depth(s.twin.cameras[0].lens, x, y, z_mm);
    }
}

std::vector<OtherSurfaceRow> rows_of(const SyntheticSides& s) {
  return other_surfaces(s.twin, s.real, s.simulated);
}

/// Takes the simulated side's phases away in a rectangle.
void take_simulated(SyntheticSides& s, const Square& square = {}) {
  measure::CameraDecode& decode = s.simulated.measurement->cameras[0];
  for (int y = square.top; y < square.top + square.height; ++y)
    for (int x = square.left; x < square.left + square.width; ++x)
      decode.flags(x, y) = measure::kLowModulation;
}

/// Rays within a square of 20 px are of one length to 1 in 300: 0.1 mm of 30.
constexpr double kOfRays_mm = 0.1;

TEST(OtherSurfaces, ARightTwinHasNone) { EXPECT_THAT(rows_of(scene()), IsEmpty()); }

TEST(OtherSurfaces, AnObjectBeforeTheWallIsNamedWithItsPlace) {
  SyntheticSides s = scene();
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm);
  const std::vector<OtherSurfaceRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  const OtherSurfaceRow& row = rows[0];
  EXPECT_EQ(row.camera, "left");
  EXPECT_EQ(row.n, 400u);
  EXPECT_EQ(row.n_other_order, 400u);
  EXPECT_THAT(row.middle_px, ElementsAre(kLeft + 9.5, kTop + 9.5));
  EXPECT_EQ(row.object, "wall");
  EXPECT_EQ(row.seen, "");
  EXPECT_NEAR(row.before_mm, kNearer_mm, kOfRays_mm + 0.5);  // along the ray, which is oblique
  ASSERT_THAT(row.place_mm, SizeIs(3));
  EXPECT_NEAR(row.place_mm[2], kWall_mm - kNearer_mm, 1e-9);
  EXPECT_THAT(row.why,
              AllOf(HasSubstr("something stands there that the twin does not have"),
                    HasSubstr("400 pixels around camera pixel (70, 60)"), HasSubstr("mm before \"wall\"")));
}

TEST(OtherSurfaces, SevenPixelsSquareAreFoundSixAreNot) {
  for (const int side : {6, 7}) {
    SyntheticSides s = scene();
    plant(s, s.real, kOther_px, kWall_mm - kNearer_mm, {side, side});
    EXPECT_THAT(rows_of(s), SizeIs(side == 7 ? 1 : 0)) << side;
  }
}

// More than 0.9 million pixels of both sides: 1e-5 of them are more than the 9 of the core of 7 x 7.
TEST(OtherSurfaces, OfALargeImageTheSmallestAreaIsLarger) {
  SyntheticSides s = scene({.width = 1400, .height = 1300, .steps = 3, .pitches_px = {kPitch_px}});
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm, {7, 7, 700, 600});
  EXPECT_THAT(rows_of(s), IsEmpty());
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm, {10, 10, 700, 700});
  EXPECT_THAT(rows_of(s), SizeIs(1));
}

// An outline that is a pixel or two elsewhere is a band as long as the object.
TEST(OtherSurfaces, ABandAtAnOutlineIsNone) {
  SyntheticSides s = scene();
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm, {4, 60});
  EXPECT_THAT(rows_of(s), IsEmpty());
}

// Wrong fringe orders are off by whole periods, and take the points of one camera along.
TEST(OtherSurfaces, WrongFringeOrdersAreNone) {
  SyntheticSides s = scene();
  plant(s, s.real, 2.0 * kPitch_px, kWall_mm - kNearer_mm);
  EXPECT_THAT(rows_of(s), IsEmpty());
  s.twin.measure.triangulate = Triangulate::stereo;  // two cameras' points do not follow wrong orders
  EXPECT_THAT(rows_of(s), SizeIs(1));
}

// What else is off by part of a period in the whole image makes no other places of wrong orders.
TEST(OtherSurfaces, WrongFringeOrdersAreNoneBesideAShiftOfAllFringes) {
  SyntheticSides s = scene();
  for (double& x : s.real.measurement->cameras[0].directions[0].coordinate_px.data) x += 0.1 * kPitch_px;
  plant(s, s.real, 2.0 * kPitch_px, kWall_mm - kNearer_mm);
  EXPECT_THAT(rows_of(s), IsEmpty());
  plant(s, s.real, 0.4 * kPitch_px, kWall_mm - kNearer_mm);
  EXPECT_THAT(rows_of(s), SizeIs(1));
}

TEST(OtherSurfaces, FringesThatAreElsewhereInMostOfTheImageAreNone) {
  SyntheticSides s = scene();
  for (double& x : s.real.measurement->cameras[0].directions[0].coordinate_px.data) x += kOther_px;
  plant(s, s.real, 0.0, kWall_mm - kNearer_mm);
  EXPECT_THAT(rows_of(s), IsEmpty());
}

TEST(OtherSurfaces, AnObjectThatTheTwinInventsIsNamed) {
  SyntheticSides s = scene();
  s.twin.objects.push_back({"box", plane_at(kWall_mm - kNearer_mm), {}});
  plant(s, s.simulated, kOther_px, kWall_mm - kNearer_mm);
  const std::vector<OtherSurfaceRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].object, "box");
  EXPECT_EQ(rows[0].seen, "wall");
  EXPECT_NEAR(rows[0].before_mm, -kNearer_mm, kOfRays_mm + 0.5);
  EXPECT_THAT(rows[0].why, AllOf(HasSubstr("the twin has \"box\" where the rig shows \"wall\": 400 pixels"),
                                 HasSubstr("mm behind it")));
}

// Of fine fringes half a period is less than the gate: a dent in a surface that both sides have.
TEST(OtherSurfaces, ADentOfMoreThanHalfAFringeIsNamed) {
  SyntheticSides s = scene();
  plant(s, s.real, 0.6 * kPitch_px, kWall_mm + 1.0);
  const std::vector<OtherSurfaceRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_THAT(rows[0].why, AllOf(HasSubstr("\"wall\" lies elsewhere there than the twin says"),
                                 HasSubstr("mm farther away")));
  s = scene();  // the same phase without another place: the projector is elsewhere
  plant(s, s.real, 0.6 * kPitch_px, kWall_mm);
  EXPECT_THAT(rows_of(s), IsEmpty());
}

// Where the twin has nothing, the real side alone measures: those points tell.
TEST(OtherSurfaces, AnObjectBeforeNothingIsNamed) {
  SyntheticSides s = scene();
  plant(s, s.real, 0.0, kWall_mm - kNearer_mm);
  take_simulated(s);
  put_wall(s.twin, s.simulated);
  const std::vector<OtherSurfaceRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].n, 400u);
  EXPECT_EQ(rows[0].n_other_order, 0u);
  EXPECT_EQ(rows[0].object, "");
  EXPECT_TRUE(std::isnan(rows[0].before_mm));
  s = scene();  // the same pixels, of a surface that the twin has and the simulated side missed
  take_simulated(s);
  put_wall(s.twin, s.simulated);
  EXPECT_THAT(rows_of(s), IsEmpty());
}

// Wrong orders that no simulated phase tells to be whole ones: each pixel is somewhere else.
TEST(OtherSurfaces, ScatteredPointsThatTheRealSideAloneMeasuredAreNone) {
  SyntheticSides s = scene();
  take_simulated(s);
  for (int i = 0; i < 400; ++i)
    plant(s, s.real, 0.0, kWall_mm + (i * 7 % 5 - 2) * 10.0, {1, 1, kLeft + i % 20, kTop + i / 20});
  EXPECT_THAT(rows_of(s), IsEmpty());
  plant(s, s.real, 0.0, kWall_mm - kNearer_mm);
  EXPECT_THAT(rows_of(s), SizeIs(1));
}

// One pixel of a wrong order says nothing of an area that the real side alone measured.
TEST(OtherSurfaces, AnObjectBeforeNothingIsFoundDespiteAWrongOrder) {
  SyntheticSides s = scene();
  plant(s, s.real, 0.0, kWall_mm - kNearer_mm);
  take_simulated(s);
  s.simulated.measurement->cameras[0].flags(kLeft + 9, kTop + 9) = measure::kValid;
  plant(s, s.real, kPitch_px, kWall_mm - kNearer_mm, {1, 1, kLeft + 9, kTop + 9});
  const std::vector<OtherSurfaceRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].n_other_order, 1u);
}

// An outline that is a pixel elsewhere, and that the object touches, neither hides nor moves it.
TEST(OtherSurfaces, AnObjectThatTouchesABandIsFoundByItself) {
  SyntheticSides s = scene();
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm, {10, 10, 100, 80});
  for (const Square& band : {Square{40, 1, 60, 84}, Square{1, 60, 60, 50}}) take_simulated(s, band);
  const std::vector<OtherSurfaceRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].n, 100u);
  EXPECT_EQ(rows[0].n_other_order, 100u);
  EXPECT_THAT(rows[0].middle_px, ElementsAre(104.5, 84.5));
  EXPECT_EQ(rows[0].seen, "");
}

// Of so many points a part is asked: here 2000 of 3600.
TEST(OtherSurfaces, OfALargeAreaAPartOfThePointsTells) {
  SyntheticSides s = scene();
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm, {60, 60});
  std::vector<OtherSurfaceRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].n, 3600u);
  EXPECT_EQ(rows[0].n_other_order, 3600u);
  EXPECT_EQ(rows[0].seen, "");
  EXPECT_NEAR(rows[0].place_mm[2], kWall_mm - kNearer_mm, 1e-9);
  plant(s, s.real, 0.0, kWall_mm, {60, 33});  // 55 % of the points are on the wall
  rows = rows_of(s);
  ASSERT_THAT(rows, IsEmpty());
}

// Points that could be on either side of the narrowest gate name no object.
TEST(OtherSurfaces, TheSmallestGateSaysWhichPointsTell) {
  SyntheticSides s = scene();
  s.twin.objects.push_back({"far plate", plane_at(2.0 * kWall_mm), {}});
  s.twin.measure.fits.resize(2);
  s.twin.measure.fits[0].object = "wall", s.twin.measure.fits[0].gate_mm = 0.5;
  s.twin.measure.fits[1].object = "far plate", s.twin.measure.fits[1].gate_mm = 5.0;
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm);
  EXPECT_THAT(rows_of(s), SizeIs(1));
  for (float& sigma_mm : s.real.measurement->cloud.sigma_mm) sigma_mm = 0.2F;
  EXPECT_THAT(rows_of(s), IsEmpty());
}

TEST(OtherSurfaces, PointsAsPoorAsTheGateTellNothing) {
  SyntheticSides s = scene();
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm);
  for (float& sigma_mm : s.real.measurement->cloud.sigma_mm) sigma_mm = 0.7F;  // 3 of it are beyond 2 mm
  EXPECT_THAT(rows_of(s), IsEmpty());
}

TEST(OtherSurfaces, WithoutPointsThePhaseTells) {
  SyntheticSides s = scene();
  plant(s, s.real, kOther_px, kWall_mm);
  for (Side* side : {&s.real, &s.simulated}) side->measurement->cloud = {};
  const std::vector<OtherSurfaceRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].object, "");
  EXPECT_THAT(rows[0].place_mm, IsEmpty());
  EXPECT_THAT(rows[0].why, HasSubstr("the rig shows something else there than the twin: 400 pixels"));
}

// Noise gives one pixel another order in an area of which nothing else is known.
TEST(OtherSurfaces, WithoutPointsOnePixelIsNoSurface) {
  SyntheticSides s = scene();
  take_simulated(s, {40, 40});
  s.simulated.measurement->cameras[0].flags(kLeft + 20, kTop + 20) = measure::kValid;
  plant(s, s.real, kOther_px, kWall_mm, {1, 1, kLeft + 20, kTop + 20});
  for (Side* side : {&s.real, &s.simulated}) side->measurement->cloud = {};
  EXPECT_THAT(rows_of(s), IsEmpty());
}

TEST(OtherSurfaces, AnObjectMadeFromTheCaptureIsNoTruth) {
  SyntheticSides s = scene();
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm);
  s.twin.objects.push_back({"part", MeasuredShape{}, {}});
  EXPECT_THAT(rows_of(s), IsEmpty());
}

// 100 of 21,000 pixels: so few of other order are no fault of a phase by themselves.
TEST(OtherSurfaces, NothingIsExplainedThatAnotherSurfaceIsIn) {
  SyntheticSides s = scene();
  Comparison c = compare(s.twin, s.real, s.simulated, {});
  ASSERT_EQ(c.budget_verdict().coverage, kExplained);
  ASSERT_NE(c.budget_verdict().phase, kNotExplained);
  plant(s, s.real, kOther_px, kWall_mm - kNearer_mm, {10, 10});
  c = compare(s.twin, s.real, s.simulated, {});
  ASSERT_THAT(c.other_surfaces, SizeIs(1));
  EXPECT_LT(c.phase[0].order_disagree_fraction(), 0.01);
  EXPECT_EQ(c.budget_verdict().coverage, kNotExplained);
  EXPECT_EQ(c.budget_verdict().phase, kNotExplained);
  EXPECT_THAT(c.explained,
              Contains(::testing::Field(&ExplainedRow::why, HasSubstr("100 pixels of other fringe order"))));
  EXPECT_THAT(c.warnings, Contains(HasSubstr("left: something stands there")));
}

}  // namespace
}  // namespace fringetwin::compare::other_surfaces_test
