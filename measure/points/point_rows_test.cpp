// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                                 |
// |-----------|------|----------------------------------------|
// | 1e-12     | px   | root of a mean of squares, rounding    |
#include "measure/points/point_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fringetwin::measure::point_rows_test {
namespace {

// Each sum goes over all rows, and no count is that of another.
TEST(PointRows, EveryRowsPointsAndCountsAreInTheSums) {
  std::vector<PointRow> rows(3);
  rows[0].add({1.0, 2.0}, {10.0, 20.0, 300.0}, 0.5, 0.25);
  rows[0].summary.n_candidates = 10, rows[0].summary.n_no_match = 3;
  rows[0].summary.n_ambiguous = 2, rows[0].summary.n_rejected = 4;
  rows[0].summary.n_too_uncertain = 1;
  rows[2].add({7.0, 5.0}, {-4.0, 8.0, 250.0}, 0.125, -0.5);
  rows[2].add({8.0, 5.0}, {-3.0, 8.5, 251.0}, 0.25, 1.0);
  rows[2].summary.n_candidates = 100, rows[2].summary.n_no_match = 30;
  rows[2].summary.n_ambiguous = 20, rows[2].summary.n_rejected = 40;
  rows[2].summary.n_too_uncertain = 15;
  Pose T_world_cam;  // a quarter turn about z, then a shift
  T_world_cam.rotation << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  T_world_cam.translation_mm = {1.0, 2.0, 3.0};
  TriangulationSummary summary;
  const PointCloud cloud = join_rows(rows, T_world_cam, &summary);
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.p_world_mm[0], Eigen::Vector3d(-19.0, 12.0, 303.0));
  EXPECT_EQ(cloud.p_world_mm[2], Eigen::Vector3d(-7.5, -1.0, 254.0));
  EXPECT_EQ(cloud.q_cam_px[1], Eigen::Vector2f(7.0F, 5.0F));
  EXPECT_EQ(cloud.sigma_mm, (std::vector<float>{0.5F, 0.125F, 0.25F}));
  EXPECT_EQ(summary.n_points, 3u);
  EXPECT_EQ(summary.n_candidates, 110u);
  EXPECT_EQ(summary.n_no_match, 33u);
  EXPECT_EQ(summary.n_ambiguous, 22u);
  EXPECT_EQ(summary.n_rejected, 44u);
  EXPECT_EQ(summary.n_too_uncertain, 16u);
  EXPECT_NEAR(summary.residual_rms_px, std::sqrt((0.0625 + 0.25 + 1.0) / 3.0), 1e-12);
}

// What is too uncertain neither has a point nor speaks against the poses, and a few pixels speak against
// nothing.
TEST(TriangulationSummary, WhatIsTooUncertainOrTooFewAccusesNothing) {
  TriangulationSummary summary{.n_candidates = 2000, .n_points = 200, .n_no_match = 800, .n_rejected = 1000};
  EXPECT_TRUE(mostly_rejected(summary));
  summary.n_too_uncertain = 900;
  EXPECT_NEAR(rejected_share(summary), 1.0 / 3.0, 1e-12);
  EXPECT_FALSE(mostly_rejected(summary));
  summary.n_too_uncertain = 1000, summary.n_points = 0, summary.n_no_match = 1000;
  EXPECT_EQ(rejected_share(summary), 0.0);
  EXPECT_FALSE(mostly_rejected({.n_candidates = 9000, .n_no_match = 8993, .n_rejected = 7}));
}

}  // namespace
}  // namespace fringetwin::measure::point_rows_test
