// SPDX-License-Identifier: Apache-2.0
// A projector solved from lit points, which are drawn here by plain projection.
//
// | check                        | tolerance        | origin                                                |
// |------------------------------|------------------|-------------------------------------------------------|
// | exact points                 | 1e-6 px, 1e-6 mm | least squares of exact data, conditioned to 1e5       |
// | 60 draws, mean square of     | 0.45 ... 1.65    | chi2 of 60 over 60: 3 sigma are 1 +- 0.55, and the    |
// | each error over its sigma    |                  | sigma of 100 tiles is known to 7 % (14 % of a square) |
#include "calib/solve/projector_from_points.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "twin/base/errors.hpp"

namespace fringetwin::calib::projector_from_points_test {
namespace {

using P = ProjectorParameter;

struct Truth {
  double fx = 1900.0, fy = 1880.0, cx = 490.0, cy = 620.0, k1 = 0.0;
  Pose T_projector_world = pose_from_rt((RotTrans() << 0.05, -0.22, 0.03, 140.0, -35.0, 20.0).finished());
};

/// Points of a scene with `depth_mm` between its nearest and its farthest, in 10 x 10 tiles of 3 x 3.
std::vector<LitPoint> scene(const Truth& truth, double depth_mm, bool rows) {
  std::vector<LitPoint> out;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 30; ++x) {
      const double z =
          1200.0 + depth_mm * (0.5 * std::sin(0.4 * x) * std::cos(0.3 * y) + 0.02 * ((x * 7 + y * 13) % 11));
      LitPoint p;
      p.p_world_mm = {(x - 14.5) / 60.0 * z, (y - 14.5) / 70.0 * z, z};
      const Eigen::Vector3d q = truth.T_projector_world * p.p_world_mm;
      const double a = q.x() / q.z(), b = q.y() / q.z(), radial = 1.0 + truth.k1 * (a * a + b * b);
      p.q_projector_px = {truth.fx * a * radial + truth.cx, truth.fy * b * radial + truth.cy};
      if (!rows) p.q_projector_px.y() = std::numeric_limits<double>::quiet_NaN();
      p.sigma_px = {0.1, 0.1};
      p.tile = y / 3 * 10 + x / 3;
      out.push_back(p);
    }
  return out;
}

std::array<double, P::count> true_parameters(const Truth& truth) {
  const RotTrans rt = rt_from_pose(truth.T_projector_world);
  return {truth.fx, truth.fy, truth.cx, truth.cy, rt[0], rt[1], rt[2], rt[3], rt[4], rt[5], truth.k1};
}

const ProjectorFromOptions kOptions{.imagersize_px = {1024, 768}, .solve_k1 = true};

TEST(ProjectorFromPoints, ExactColumnsGiveItsSevenNumbers) {
  const Truth truth;
  const ProjectorFromPoints s =
      projector_from_points(scene(truth, 300.0, false), {.imagersize_px = {1024, 768}}, "scene");
  const auto expected = true_parameters(truth);
  EXPECT_FALSE(s.rows);
  EXPECT_EQ(s.lensmodel, "LENSMODEL_PINHOLE");
  for (const int i : {P::fx, P::cx, P::r, P::r + 1, P::r + 2, P::t, P::t + 2})
    EXPECT_NEAR(s.parameters[i], expected[i], 1e-6) << P::names()[i];
  // by convention
  EXPECT_EQ(s.parameters[P::fy], s.parameters[P::fx]);
  for (const int i : {P::fy, P::cy, P::t + 1, P::k1}) EXPECT_EQ(s.sigma[i], 0.0) << P::names()[i];
  // the centre lies on the line that all columns share: through the true centre, along the columns
  const Eigen::Vector3d off =
      s.T_projector_world().inverse().translation_mm - truth.T_projector_world.inverse().translation_mm;
  const Eigen::Vector3d along = truth.T_projector_world.rotation.row(1);
  EXPECT_NEAR(off.cross(along).norm(), 0.0, 1e-6);
}

TEST(ProjectorFromPoints, ExactColumnsGiveTheDistortionWhereTheCentreIsAsAssumed) {
  const Truth truth{.k1 = -0.08};
  const ProjectorFromPoints s =
      projector_from_points(scene(truth, 300.0, false),
                            {.imagersize_px = {1024, 768},
                             .solve_k1 = true,
                             .near_world_mm = truth.T_projector_world.inverse().translation_mm},
                            "scene");
  EXPECT_EQ(s.lensmodel, "LENSMODEL_OPENCV4");
  // the place along the columns follows the rotation, and it the place, in three rounds
  EXPECT_NEAR(s.parameters[P::k1], truth.k1, 1e-3 * std::abs(truth.k1));
  EXPECT_LT(s.rms_px, 1e-3);
}

TEST(ProjectorFromPoints, ExactRowsGiveAllAndTheDistortion) {
  const Truth truth{.k1 = -0.08};
  const ProjectorFromPoints s = projector_from_points(scene(truth, 300.0, true), kOptions, "scene");
  const auto expected = true_parameters(truth);
  EXPECT_TRUE(s.rows);
  EXPECT_EQ(s.intrinsics().size(), 8U);
  for (int i = 0; i < P::count; ++i) EXPECT_NEAR(s.parameters[i], expected[i], 1e-5) << P::names()[i];
}

/// Noise of each coordinate, of each tile's shape, which neighbours share, and of each depth, 150 times less
/// than the scene is deep.
void add_noise(std::vector<LitPoint>& points, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  constexpr double kDepthNoise = 0.5;  // mm
  for (LitPoint& p : points) {
    p.p_world_mm *= 1.0 + kDepthNoise * normal(random) / p.p_world_mm.norm();
    p.depth_sigma_mm = kDepthNoise;
  }
  std::vector<Eigen::Vector2d> of_tile(100);
  for (auto& t : of_tile) t = {0.06 * normal(random), 0.06 * normal(random)};
  for (LitPoint& p : points)
    p.q_projector_px += of_tile[p.tile] + 0.1 * Eigen::Vector2d(normal(random), normal(random));
}

TEST(ProjectorFromPoints, SigmasHoldWhereNeighboursShareTheirErrors) {
  for (const bool rows : {false, true}) {
    const Truth truth{.k1 = rows ? -0.08 : 0.0};
    const auto expected = true_parameters(truth);
    std::mt19937_64 random(17);
    std::array<double, P::count> chi2{};
    constexpr int kDraws = 60;
    for (int draw = 0; draw < kDraws; ++draw) {
      std::vector<LitPoint> points = scene(truth, 300.0, rows);
      add_noise(points, random);
      const ProjectorFromPoints s =
          projector_from_points(points, {.imagersize_px = {1024, 768}, .solve_k1 = rows}, "scene");
      for (int i = 0; i < P::count; ++i)
        if (s.sigma[i] > 0.0) chi2[i] += std::pow((s.parameters[i] - expected[i]) / s.sigma[i], 2) / kDraws;
    }
    for (int i = 0; i < P::count; ++i) {
      if (!rows && (i == P::fy || i == P::cy || i == P::t + 1 || i == P::k1)) continue;
      EXPECT_GT(chi2[i], 0.45) << P::names()[i] << (rows ? " with rows" : "");
      EXPECT_LT(chi2[i], 1.65) << P::names()[i] << (rows ? " with rows" : "");
    }
  }
}

TEST(ProjectorFromPoints, PointsOfAnotherFringeAreOutliers) {
  const Truth truth;
  std::vector<LitPoint> points = scene(truth, 300.0, false);
  std::mt19937_64 random(3);
  add_noise(points, random);
  for (std::size_t i = 0; i < points.size(); i += 20) points[i].q_projector_px.x() += i % 40 ? 16.0 : -16.0;
  const ProjectorFromPoints s = projector_from_points(points, kOptions, "scene");
  EXPECT_EQ(s.n_outliers, 45U);
  EXPECT_NEAR(s.parameters[P::fx], truth.fx, 4.0 * s.sigma[P::fx]);
}

std::string refusal(const std::vector<LitPoint>& points) {
  try {
    projector_from_points(points, kOptions, "scene");
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    return e.what();
  }
  return "";
}

TEST(ProjectorFromPoints, WhatDoesNotTellAProjectorIsRefused) {
  std::vector<LitPoint> flat = scene({}, 0.0, false);
  EXPECT_THAT(refusal(flat), ::testing::HasSubstr("lie in one plane"));
  std::mt19937_64 random(5);
  add_noise(flat, random);
  EXPECT_THAT(refusal(flat),
              ::testing::AnyOf(::testing::HasSubstr("too flat"), ::testing::HasSubstr("one plane")));
  // relief that is the noise of the depths, which least squares would take for relief, and a few false
  // matches
  std::normal_distribution<double> normal;
  std::vector<LitPoint> rough = scene({}, 0.0, false);
  for (LitPoint& p : rough) p.p_world_mm *= 1.0 + normal(random) / 1200.0, p.depth_sigma_mm = 1.0;
  for (std::size_t i = 0; i < rough.size(); i += 50) rough[i].p_world_mm *= 1.0 + 0.15 * normal(random);
  EXPECT_THAT(refusal(rough), ::testing::HasSubstr("too flat a part"));
  std::vector<LitPoint> few = scene({}, 300.0, false);
  few.resize(400);
  EXPECT_THAT(refusal(few), ::testing::HasSubstr("400 lit points are too few"));
  std::vector<LitPoint> small = scene({}, 300.0, false);
  for (LitPoint& p : small) p.tile = 0;
  EXPECT_THAT(refusal(small), ::testing::HasSubstr("fill 1 tiles"));
  std::vector<LitPoint> mirrored = scene({}, 300.0, true);
  for (LitPoint& p : mirrored) p.q_projector_px.y() *= -1.0;
  EXPECT_THAT(refusal(mirrored), ::testing::HasSubstr("as in a mirror"));
}

}  // namespace
}  // namespace fringetwin::calib::projector_from_points_test
