// SPDX-License-Identifier: Apache-2.0
// Truth: the paper's Table 5 and hand calculations; tolerance 1e-12 (double rounding of a subtraction).
#include "compare/geometry/fit_rows.hpp"

#include <gtest/gtest.h>

#include "compare/result/fit_keys.hpp"
#include "compare/verdict/explained.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::fit_rows_test {
namespace {

using measure::ObjectFit;

ObjectFit sphere(double x, double y, double z, double r, double rms) {
  ObjectFit fit;
  fit.object = "ball";
  fit.kind = "sphere";
  fit.usable = true;
  fit.n = 1000;
  fit.numbers = {{"radius_mm", r}, {"rms_mm", rms}};
  fit.vectors = {{"center_mm", {x, y, z}}};
  return fit;
}

TEST(FitRows, SigmaKeysFollowTheirUnit) {
  EXPECT_EQ(sigma_key("radius_mm"), "radius_sigma_mm");
  EXPECT_EQ(sigma_key("center_mm"), "center_sigma_mm");
  EXPECT_EQ(sigma_key("tilt_rad"), "tilt_sigma_rad");
  EXPECT_EQ(sigma_key("normal"), "normal_sigma");
  EXPECT_EQ(sigma_key("tilt_rad_1"), "tilt_sigma_rad_1");
  EXPECT_EQ(sigma_key("axis_shift_mm_0"), "axis_shift_sigma_mm_0");
  EXPECT_TRUE(is_sigma_key("center_sigma_mm"));
  EXPECT_FALSE(is_sigma_key("center_mm"));
}

TEST(FitRows, Table5OfThePaper) {
  const FitRow row = make_fit_row(sphere(6.564, -5.499, 270.626, 19.061, 0.008),
                                  sphere(6.567, -5.497, 270.634, 19.065, 0.013));
  const Eigen::Vector3d d = row.difference_vectors.at("center_mm");
  EXPECT_NEAR(d.x(), -0.003, 1e-12);
  EXPECT_NEAR(d.y(), -0.002, 1e-12);
  EXPECT_NEAR(d.z(), -0.008, 1e-12);
  EXPECT_NEAR(row.difference.at("radius_mm"), -0.004, 1e-12);
  EXPECT_NEAR(row.difference.at("rms_mm"), -0.005, 1e-12);
  EXPECT_TRUE(row.z.empty());  // the paper gives no uncertainty
  EXPECT_TRUE(row.z_vectors.empty());
}

TEST(FitRows, ZUsesBothSigmas) {
  ObjectFit s = sphere(0, 0, 250, 10.003, 0.01), r = sphere(0, 0, 250, 10, 0.01);
  s.numbers["radius_sigma_mm"] = 0.003;
  r.numbers["radius_sigma_mm"] = 0.004;
  s.vectors["center_sigma_mm"] = {0.001, 0.001, 0.001};
  EXPECT_NEAR(make_fit_row(s, r).z.at("radius_mm"), 0.6, 1e-9);
  EXPECT_TRUE(make_fit_row(s, r).z_vectors.empty());  // one side's centre sigma is unknown
  r.vectors["center_sigma_mm"] = {0.001, 0.001, std::nan("")};
  const Eigen::Vector3d z = make_fit_row(s, r).z_vectors.at("center_mm");
  EXPECT_EQ(z.x(), 0.0);
  EXPECT_TRUE(std::isnan(z.z()));
  EXPECT_FALSE(make_fit_row(s, r).difference.contains("radius_sigma_mm"));
}

TEST(FitRows, PlanesCompareByOffsetAndAngle) {
  ObjectFit s, r;
  s.kind = r.kind = "plane";
  s.usable = r.usable = true;
  const double tilt = 1e-5;
  r.vectors = {{"point_mm", {10, 20, 300}}, {"normal", {0, 0, -1}}};
  s.vectors = {{"point_mm", {-5, 3, 300.002}}, {"normal", {0, std::sin(tilt), -std::cos(tilt)}}};
  const FitRow row = make_fit_row(s, r);
  EXPECT_NEAR(row.difference.at("angle_rad"), tilt, 1e-15);
  EXPECT_NEAR(row.difference.at("offset_mm"), -0.002, 1e-9);  // along the real normal, towards the viewer
}

TEST(FitRows, APlanesOffsetHasItsZ) {
  ObjectFit s, r;
  s.kind = r.kind = "plane";
  s.usable = r.usable = true;
  r.vectors = {{"point_mm", {0, 0, 300}}, {"normal", {0, 0, -1}}};
  s.vectors = {{"point_mm", {30, 40, 299.99}}, {"normal", {0, 0, -1}}};
  r.numbers = {{"offset_sigma_mm", 0.003}, {"tilt_sigma_rad_0", 1e-5}, {"tilt_sigma_rad_1", 2.4e-4}};
  s.numbers = {{"offset_sigma_mm", 0.004}, {"tilt_sigma_rad_0", 1e-5}, {"tilt_sigma_rad_1", 1e-5}};
  // 0.01 over the root of 0.003^2 + 0.004^2 + (50 * 2.4e-4)^2 = 0.013^2
  EXPECT_NEAR(make_fit_row(s, r).z.at("offset_mm"), 0.01 / 0.013, 1e-9);
  r.numbers.erase("tilt_sigma_rad_1");
  EXPECT_FALSE(make_fit_row(s, r).z.contains("offset_mm"));
}

/// Two planes through one centroid with tilt sigmas of 3e-6 and 4e-6 rad: 5e-6 of the difference.
FitRow tilted_planes(const Eigen::Vector3d& real_normal) {
  ObjectFit s;
  s.object = "wall";
  s.kind = "plane";
  s.usable = true;
  s.vectors = {{"point_mm", {0, 0, 300}},
               {"normal", {0, 0, -1}},
               {"tilt_direction_0", {1, 0, 0}},
               {"tilt_direction_1", {0, -1, 0}}};
  s.numbers = {{"offset_sigma_mm", 1e-4}, {"tilt_sigma_rad_0", 3e-6}, {"tilt_sigma_rad_1", 3e-6}};
  ObjectFit r = s;
  r.vectors["normal"] = real_normal.normalized();
  r.numbers["tilt_sigma_rad_0"] = r.numbers["tilt_sigma_rad_1"] = 4e-6;
  return make_fit_row(s, r);
}

TEST(FitRows, ATiltAboutTheCentroidIsJudged) {
  const auto state = [](const FitRow& row) { return explain_geometry({row}).at(0).state; };
  // the real plane recedes along x, so the simulated one rises towards the viewer beside it
  const FitRow little = tilted_planes({5e-6, 0, -1}), far = tilted_planes({5e-6, 25e-6, -1});
  EXPECT_NEAR(little.difference.at("tilt_rad_0"), 5e-6, 1e-12);
  EXPECT_NEAR(little.z.at("tilt_rad_0"), 1.0, 1e-9);
  EXPECT_EQ(little.z.at("offset_mm"), 0.0);
  EXPECT_EQ(state(little), "explained");
  EXPECT_NEAR(far.difference.at("tilt_rad_1"), -25e-6, 1e-12);
  EXPECT_NEAR(far.z.at("tilt_rad_1"), -5.0, 1e-6);
  EXPECT_EQ(state(far), "not explained");
  EXPECT_EQ(explain_geometry({far}).at(0).worst, "tilt_rad_1");
  EXPECT_EQ(explain_geometry({far}).at(0).unit, "rad");
  EXPECT_FALSE(far.difference_vectors.contains("tilt_direction_0"));

  const double wide = 83.0 * M_PI / 180.0;
  const Eigen::Vector3d normal(std::sin(wide), 0, -std::cos(wide));
  for (const Eigen::Vector3d& either : {normal, Eigen::Vector3d(-normal)}) {
    EXPECT_NEAR(tilted_planes(either).difference.at("tilt_rad_0"), wide, 1e-12);
    EXPECT_EQ(state(tilted_planes(either)), "not explained");
  }
}

TEST(FitRows, CylindersCompareByTiltsAndShifts) {
  ObjectFit s;
  s.kind = "cylinder";
  s.usable = true;
  s.vectors = {{"point_mm", {0.003, 50, 300.004}},
               {"axis", {0, 1, 0}},
               {"tilt_direction_0", {1, 0, 0}},
               {"tilt_direction_1", {0, 0, -1}}};
  for (const char* end : {"_0", "_1"}) {
    s.numbers[std::string("axis_sigma_rad") + end] = 2.4e-4;
    s.numbers[std::string("axis_shift_sigma_mm") + end] = 0.003;
  }
  ObjectFit r = s;
  r.vectors["point_mm"] = {0, 0, 300};
  r.vectors["axis"] = {2e-4, -1, 0};  // the sense of an axis means nothing
  r.numbers["axis_sigma_rad_0"] = 0.7e-4;
  r.numbers["axis_shift_sigma_mm_0"] = r.numbers["axis_shift_sigma_mm_1"] = 0.004;
  const FitRow row = make_fit_row(s, r);
  EXPECT_NEAR(row.difference.at("axis_rad_0"), 2e-4, 1e-10);
  EXPECT_NEAR(row.z.at("axis_rad_0"), 2.0 / 2.5, 1e-6);
  EXPECT_NEAR(row.difference.at("axis_shift_mm_1"), -0.004, 1e-12);
  // 3 and 4 um, and 50 mm of the simulated axis's tilt: 12 um
  EXPECT_NEAR(row.z.at("axis_shift_mm_0"), 3.0 / 13.0, 1e-9);
  EXPECT_NEAR(row.z.at("axis_shift_mm_1"), -4.0 / 13.0, 1e-9);
}

TEST(FitRows, CylindersCompareByAxis) {
  ObjectFit s, r;
  s.kind = r.kind = "cylinder";
  s.usable = r.usable = true;
  r.vectors = {{"point_mm", {0, 0, 300}}, {"axis", {0, 1, 0}}};
  s.vectors = {{"point_mm", {0.003, 77, 300.004}}, {"axis", {0, -1, 0}}};
  const FitRow row = make_fit_row(s, r);
  EXPECT_NEAR(row.difference.at("axis_distance_mm"), 0.005, 1e-9);
  EXPECT_NEAR(row.difference.at("angle_rad"), 0.0, 1e-15);  // the sense of an axis means nothing
}

TEST(FitRows, PublishedNumbersStandInForAMissingRealSide) {
  testing::SidesTruth t;
  t.published_only = true;
  testing::SyntheticSides scene = testing::make_sides(t);
  scene.twin.real.results.push_back(
      {"ball", {{"radius_mm", 19.065}, {"rms_mm", 0.013}}, {{"center_mm", {6.567, -5.497, 270.634}}}});
  std::vector<std::string> warnings;
  const std::vector<FitRow> rows = fit_rows(scene.twin, scene.real, scene.simulated, warnings);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].real->n, 0u);
  EXPECT_EQ(rows[0].real->kind, "sphere");
  EXPECT_NEAR(rows[0].difference.at("radius_mm"), 0.0001, 1e-9);
  EXPECT_TRUE(warnings.empty());
}

TEST(FitRows, AFitWithTooFewPointsIsListedWithAWarningAndNoDifference) {
  testing::SyntheticSides scene = testing::make_sides({});
  scene.real.measurement->fits[0].usable = false;
  scene.real.measurement->fits[0].n = 3;
  scene.real.measurement->fits[0].warning = "3 points are too few for a sphere";
  std::vector<std::string> warnings;
  const auto rows = fit_rows(scene.twin, scene.real, scene.simulated, warnings);
  EXPECT_TRUE(rows.at(0).difference.empty());
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("too few"), std::string::npos);
}

}  // namespace
}  // namespace fringetwin::compare::fit_rows_test
