// SPDX-License-Identifier: Apache-2.0
// Areas planted on one side of a made comparison are counted exactly, named with their place, and judged;
// what outlines and a little noise leave is explained. All counts follow from the sizes of what is planted.
#include "compare/verdict/coverage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::coverage_test {
namespace {

using ::testing::AllOf;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::SidesTruth;
using ::testing::SizeIs;
using testing::SyntheticSides;

/// A lit disc, whose points are those of the ball of the twin.
SyntheticSides scene(int cameras = 1) {
  SidesTruth t;
  t.cameras = cameras;
  SyntheticSides s = testing::make_sides(t);
  s.twin.objects = {{"ball", SphereShape{{6.567, -5.497, 270.634}, 19.065}, {}}};
  return s;
}

constexpr int kPatch = 20, kFirst = 5;  ///< px: a square in a corner that is not lit

/// The point of a pixel of the patch, on a plane across the axis of both cameras.
Eigen::Vector3d point_mm(const Lens& lens, int x, int y) {
  return *lens.unproject({x, y}) / lens.unproject({x, y})->z() * 300.0;
}

/// One side measures a rectangle, with points, where the other has nothing.
void plant(SyntheticSides& s, Side& side, std::size_t camera, int x0, int y0, int width, int height) {
  measure::CameraDecode& decode = side.measurement->cameras[camera];
  measure::PointCloud& cloud = side.measurement->cloud;
  for (int y = y0; y < y0 + height; ++y)
    for (int x = x0; x < x0 + width; ++x) {
      ASSERT_NE(decode.flags(x, y), measure::kValid);
      decode.flags(x, y) = measure::kValid;
      cloud.p_world_mm.push_back(point_mm(s.twin.cameras[camera].lens, x, y));
      cloud.normal_world.emplace_back(0.0F, 0.0F, -1.0F);
      cloud.q_cam_px.emplace_back(static_cast<float>(x), static_cast<float>(y));
      cloud.sigma_mm.push_back(0.01F);
    }
}

void plant(SyntheticSides& s, Side& side, std::size_t camera = 0) {
  plant(s, side, camera, kFirst, kFirst, kPatch, kPatch);
}

std::vector<CoverageRow> rows_of(const SyntheticSides& s) {
  return coverage_rows(s.twin, s.real, s.simulated);
}
std::uint64_t lit(const SyntheticSides& s) {
  const ImageU8& flags = s.simulated.measurement->cameras[0].flags;
  return static_cast<std::uint64_t>(std::count(flags.data.begin(), flags.data.end(), measure::kValid));
}

TEST(Coverage, WhatBothSidesMeasureIsExplained) {
  const SyntheticSides s = scene(2);
  const std::vector<CoverageRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(4));  // everything and the ball, in two cameras
  for (const CoverageRow& row : rows) {
    EXPECT_TRUE(row.explained) << row.why;
    EXPECT_EQ(row.n_both, lit(s));
    EXPECT_EQ(row.n_one_sided(), 0u);
    EXPECT_EQ(row.covered_fraction(), 1.0);
    EXPECT_EQ(row.one_sided_fraction(), 0.0);
  }
  EXPECT_EQ(rows[1].object, "ball");
  EXPECT_EQ(rows[2].camera, "right");
  EXPECT_THAT(coverage_warnings(rows), IsEmpty());
}

/// Checks the counts of the planted square, which is measured on one side only.
void expect_square(const OneSided& pixels, const OneSided& other) {
  // away from the outline's two pixels: 16 x 16, as many as are left after two pixels of the rim are gone
  constexpr std::uint64_t kInside = (kPatch - 4) * (kPatch - 4);
  EXPECT_EQ(pixels.n, static_cast<std::uint64_t>(kPatch * kPatch));
  EXPECT_EQ(pixels.interior, kInside);
  EXPECT_EQ(pixels.border, pixels.n - kInside);
  EXPECT_EQ(pixels.thick, kInside);
  EXPECT_EQ(other.n, 0u);
}

void expect_place(const CoverageRow& row, const Lens& lens) {
  EXPECT_THAT(row.place_box_px, ElementsAre(7.0, 7.0, 22.0, 22.0));
  // the middle of pixels 7 to 22 of a pinhole camera, whose coordinates are linear on a plane
  const Eigen::Vector3d middle = 0.5 * (point_mm(lens, 7, 7) + point_mm(lens, 22, 22));
  EXPECT_THAT(row.place_mm, ElementsAre(DoubleNear(middle.x(), 1e-9), DoubleNear(middle.y(), 1e-9),
                                        DoubleNear(middle.z(), 1e-9)));
}

TEST(Coverage, AnObjectThatTheTwinLacksIsNamedWithItsPlace) {
  for (const std::size_t camera : {0u, 1u}) {
    SyntheticSides s = scene(2);
    plant(s, s.real, camera);
    const std::vector<CoverageRow> rows = rows_of(s);
    ASSERT_THAT(rows, SizeIs(5));
    const CoverageRow &all = rows[2 * camera], &stranger = rows[2 * camera + 2];
    EXPECT_EQ(all.camera, camera == 0 ? "left" : "right");
    expect_square(all.real_only, all.simulated_only);
    EXPECT_EQ(all.real_only.lost_dark, all.real_only.n);
    EXPECT_FALSE(all.explained);
    expect_place(all, s.twin.cameras[camera].lens);
    EXPECT_EQ(all.place_object, kNotInTheTwin);
    EXPECT_EQ(stranger.object, kNotInTheTwin);
    expect_square(stranger.real_only, stranger.simulated_only);
    EXPECT_FALSE(stranger.explained);
    EXPECT_TRUE(rows[2 * camera + 1].explained) << rows[2 * camera + 1].why;  // the ball
    EXPECT_THAT(coverage_warnings(rows),
                ElementsAre(AllOf(HasSubstr("400 pixels"), HasSubstr("real side only"), HasSubstr("dark"),
                                  HasSubstr("near no object of the twin"), HasSubstr("y 7 to 22"))));
    OtherSurfaceRow told;  // a finding of all its pixels
    told.camera = all.camera, told.n = all.real_only.n;
    EXPECT_THAT(coverage_warnings(rows, {told}), IsEmpty());
    told.camera = "a third";
    EXPECT_THAT(coverage_warnings(rows, {told}), SizeIs(1));
    told.camera = all.camera, told.n = 200;
    EXPECT_THAT(coverage_warnings(rows, {told}), SizeIs(1));
    const std::vector<ExplainedRow> verdict = explain_coverage(s.twin, rows);
    ASSERT_THAT(verdict, SizeIs(2));
    EXPECT_EQ(verdict[camera].explained(), false);
    EXPECT_EQ(verdict[1 - camera].explained(), true);
  }
}

TEST(Coverage, AnObjectThatTheTwinInventsIsNamed) {
  SyntheticSides s = scene();
  PlaneShape wall;
  wall.point_mm = {0, 0, 300};
  s.twin.objects.push_back({"wall", wall, {}});
  plant(s, s.simulated);
  measure::DirectionDecode& real = s.real.measurement->cameras[0].directions[0];
  for (int y = 0; y < real.mean_dn.height; ++y)
    for (int x = 0; x < kFirst + kPatch / 2; ++x) real.mean_dn(x, y) = 50.0F;  // lit, without fringes
  const std::vector<CoverageRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(3));
  EXPECT_EQ(rows[2].object, "wall");
  for (const CoverageRow& row : {rows[0], rows[2]}) {
    expect_square(row.simulated_only, row.real_only);
    EXPECT_EQ(row.simulated_only.lost_low_modulation, 200u);
    EXPECT_EQ(row.simulated_only.lost_dark, 200u);
    EXPECT_FALSE(row.explained);
    EXPECT_EQ(row.place_object, "wall");
    expect_place(row, s.twin.cameras[0].lens);
  }
  EXPECT_TRUE(rows[1].explained) << rows[1].why;
  EXPECT_THAT(coverage_warnings(rows),
              ElementsAre(AllOf(HasSubstr("simulated side only"), HasSubstr("on \"wall\""))));
}

// A side with a few pixels of its own stands behind, or is left out beside, one with an area.
TEST(Coverage, TheSideThatIsBeyondItsAllowanceIsTheOneThatIsNamed) {
  SyntheticSides s = scene();
  plant(s, s.simulated);
  plant(s, s.real, 0, kFirst + kPatch + 8, kFirst, 6, 6);  // 2 x 2 inside
  const CoverageRow row = rows_of(s).at(0);
  ASSERT_EQ(row.real_only.interior, 4u);
  EXPECT_THAT(row.why, AllOf(HasSubstr("400 pixels"), HasSubstr("on the simulated side only")));
  EXPECT_THAT(row.why, ::testing::Not(HasSubstr("on the real side only")));
  EXPECT_DOUBLE_EQ(row.excess(), static_cast<double>(256 + 4) / row.allowed_thick);
}

TEST(Coverage, AVerdictSaysOfWhichObjectASentenceIs) {
  CoverageRow camera, ball;
  camera.camera = ball.camera = "left";
  camera.why = "one", ball.why = "two", ball.object = "ball";
  const std::vector<ExplainedRow> verdict = explain_coverage({}, {camera, ball});
  ASSERT_THAT(verdict, SizeIs(1));
  EXPECT_EQ(verdict[0].why, "one; of \"ball\" two");
}

/// Takes away the pixels at the outline of the real side, all or every so many.
void fray(SyntheticSides& s, int every) {
  const ImageU8 before = s.real.measurement->cameras[0].flags;
  ImageU8& flags = s.real.measurement->cameras[0].flags;
  int n = 0;
  for (int y = 1; y < flags.height - 1; ++y)
    for (int x = 1; x < flags.width - 1; ++x) {
      if (before(x, y) != measure::kValid) continue;
      if ((before(x - 1, y) | before(x + 1, y) | before(x, y - 1) | before(x, y + 1)) == 0) continue;
      if (n++ % every == 0) flags(x, y) = measure::kOrderInvalid;
    }
}

TEST(Coverage, AFewPixelsAtOutlinesAreExplainedAWholeRimIsNot) {
  SyntheticSides s = scene();
  fray(s, 4);
  const CoverageRow few = rows_of(s).at(0);
  EXPECT_TRUE(few.explained) << few.why;
  EXPECT_GT(few.n_border(), 50u);
  EXPECT_EQ(few.n_interior(), 0u);
  s = scene();
  fray(s, 1);
  const CoverageRow rim = rows_of(s).at(0);
  EXPECT_FALSE(rim.explained);
  EXPECT_EQ(rim.n_interior() + rim.n_thick(), 0u);
  EXPECT_EQ(rim.simulated_only.border, rim.simulated_only.n);
  EXPECT_THAT(rim.why, HasSubstr("outlines of the two sides differ"));
}

TEST(Coverage, ScatteredPixelsAreExplainedBelowThreeInAThousand) {
  for (const double share : {1e-3, 1e-2}) {
    SyntheticSides s = scene();
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform;
    measure::CameraDecode& real = s.real.measurement->cameras[0];
    for (std::size_t i = 0; i < real.flags.size(); ++i)
      if (real.flags.data[i] == measure::kValid && uniform(random) < share) {
        real.flags.data[i] = measure::kOrderInvalid;
        real.directions[0].mean_dn.data[i] = 100.0F;
      }
    const CoverageRow row = rows_of(s).at(0);
    EXPECT_EQ(row.explained, share < 3e-3) << row.why;
    EXPECT_EQ(row.n_thick(), 0u);
    EXPECT_EQ(row.simulated_only.lost_order, row.simulated_only.n);
    if (!row.explained) {
      EXPECT_THAT(row.why, HasSubstr("scattered"));
    }
  }
}

TEST(Coverage, SaturationThatTakesMostOfBothSidesIsNot) {
  for (const double share : {0.3, 0.7}) {
    SyntheticSides s = scene();
    const std::uint64_t before = lit(s);
    const int columns = static_cast<int>(share * s.simulated.measurement->cameras[0].width());
    for (Side* side : {&s.real, &s.simulated}) {
      ImageU8& flags = side->measurement->cameras[0].flags;
      for (int y = 0; y < flags.height; ++y)
        for (int x = 0; x < columns; ++x)
          if (flags(x, y) == measure::kValid) flags(x, y) = measure::kSaturated;
    }
    const CoverageRow row = rows_of(s).at(0);
    EXPECT_EQ(row.n_both, lit(s));
    EXPECT_EQ(row.n_seen, before);
    EXPECT_EQ(row.n_neither_saturated, before - lit(s));
    EXPECT_EQ(row.n_neither(), row.n_neither_saturated);
    EXPECT_EQ(row.explained, share < 0.5) << row.why;
    if (!row.explained) {
      EXPECT_THAT(row.why, HasSubstr("saturated"));
    }
  }
}

TEST(Coverage, PixelsSoNearTheClipThatNoiseDecidesAreOfNoSide) {
  SyntheticSides s = scene();
  // a strip of 20 columns in which every second pixel clips on the real side; the others, and all of the
  // simulated side, are 1 DN below the clip, or far below
  for (const bool near : {true, false}) {
    s = scene();
    for (Side* side : {&s.real, &s.simulated})
      side->measurement->cameras[0].directions[0].noise_dn = 1.5;  // 6 of it reach from 246 to the clip
    std::uint64_t clipped = 0;
    measure::CameraDecode& real = s.real.measurement->cameras[0];
    for (int y = 0; y < real.height(); ++y)
      for (int x = 90; x < 110; ++x) {
        if (real.flags(x, y) != measure::kValid) continue;
        for (Side* side : {&s.real, &s.simulated})
          side->images[0].images[0].writable(x, y) = near ? 254.0F : 200.0F;
        if ((x + y) % 2 == 0) continue;
        real.flags(x, y) = measure::kSaturated;
        s.real.images[0].images[0].writable(x, y) = 255.0F;
        ++clipped;
      }
    const CoverageRow row = rows_of(s).at(0);
    EXPECT_EQ(row.explained, near) << row.why;
    EXPECT_EQ(row.n_one_sided(), near ? 0 : clipped);
    EXPECT_EQ(row.n_neither_saturated, near ? clipped : 0);
  }
}

TEST(Coverage, AnObjectThatNobodyMeasuredIsNotCompared) {
  SyntheticSides s = scene();
  PlaneShape wall;
  wall.point_mm = {0, 0, 300};
  s.twin.objects.push_back({"wall", wall, {}});
  EXPECT_THAT(explain_coverage(s.twin, rows_of(s)), SizeIs(1));  // nobody asks for it
  s.twin.measure.fits.emplace_back().object = "wall";
  std::vector<ExplainedRow> verdict = explain_coverage(s.twin, rows_of(s));
  ASSERT_THAT(verdict, SizeIs(2));
  EXPECT_EQ(verdict[1].region, "wall");
  EXPECT_EQ(verdict[1].state, kNotCompared);
  EXPECT_THAT(verdict[1].why, HasSubstr("no camera measured"));
  for (Side* side : {&s.real, &s.simulated}) side->measurement->cloud = {};
  EXPECT_THAT(explain_coverage(s.twin, rows_of(s)), SizeIs(1));  // without points nothing is known of objects
}

TEST(Coverage, WithoutPointsThereAreRowsOfCamerasOnly) {
  SyntheticSides s = scene();
  plant(s, s.real);
  for (Side* side : {&s.real, &s.simulated}) side->measurement->cloud = {};
  const std::vector<CoverageRow> rows = rows_of(s);
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].object, "");
  EXPECT_FALSE(rows[0].explained);
  EXPECT_THAT(rows[0].place_box_px, ElementsAre(7.0, 7.0, 22.0, 22.0));
  EXPECT_THAT(rows[0].place_mm, IsEmpty());
}

// Without the two pixels at its outline; no side of the rectangle is where another one is.
TEST(Coverage, ThePlaceIsLeftTopRightAndBottom) {
  SyntheticSides s = scene();
  plant(s, s.real, 0, 3, 4, 28, 14);
  const std::vector<CoverageRow> rows = rows_of(s);
  EXPECT_THAT(rows.at(0).place_box_px, ElementsAre(5.0, 6.0, 28.0, 15.0));
  EXPECT_THAT(rows[0].why, HasSubstr("the largest area lies in pixels x 5 to 28, y 6 to 15"));
}

TEST(Coverage, NothingMeasuredIsNotExplained) {
  SyntheticSides s = scene();
  for (Side* side : {&s.real, &s.simulated})
    for (unsigned char& flag : side->measurement->cameras[0].flags.data) flag = measure::kLowModulation;
  for (Side* side : {&s.real, &s.simulated}) side->measurement->cloud = {};
  const std::vector<CoverageRow> rows = rows_of(s);
  EXPECT_FALSE(rows.at(0).explained);
  EXPECT_NE(rows[0].covered_fraction(), rows[0].covered_fraction());
  EXPECT_THAT(rows[0].why, HasSubstr("neither side has fringes"));
  s.real.measurement.reset();
  EXPECT_THAT(rows_of(s), IsEmpty());
}

TEST(Coverage, IsAVerdictAWarningAndALimitOfAComparison) {
  SyntheticSides s = scene();
  s.twin.limits = {{"one_sided_fraction", 0.01}, {"covered_fraction", 0.9}};
  Comparison c = compare(s.twin, s.real, s.simulated, {});
  EXPECT_EQ(c.budget_verdict().coverage, "explained");
  EXPECT_TRUE(c.pass);
  plant(s, s.real);
  c = compare(s.twin, s.real, s.simulated, {});
  EXPECT_EQ(c.budget_verdict().coverage, "not explained");
  // the area is warned of once, as another surface; the verdict has both sentences
  EXPECT_THAT(c.warnings, ElementsAre(HasSubstr("something stands there that the twin does not have")));
  EXPECT_THAT(c.explained,
              ::testing::Contains(::testing::Field(&ExplainedRow::why, HasSubstr("real side only"))));
  ASSERT_THAT(c.limits, SizeIs(2));
  EXPECT_EQ(c.limits[1].name, "one_sided_fraction");
  // the worst row is that of the points near no object: all of them are on one side
  EXPECT_DOUBLE_EQ(c.limits[1].value, 1.0);
  EXPECT_FALSE(c.limits[1].pass);
  EXPECT_FALSE(c.limits[0].pass);
}

}  // namespace
}  // namespace fringetwin::compare::coverage_test
