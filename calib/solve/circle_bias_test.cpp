// SPDX-License-Identifier: Apache-2.0
// The picture of a circle's centre and the centre of the circle's picture.
//
// | check                                 | tolerance      | origin                                       |
// |---------------------------------------|----------------|----------------------------------------------|
// | centroid, pinhole                     | 1e-6 px        | closed form: dual conic through a homography |
// | centroid, OPENCV4                     | 1e-5 px        | centroid of the outline, 4096-sided polygon  |
// | rig from exact centroids, corrected   | 1e-3 px (core) | the centroids are free of noise              |
// | the same as they are                  | > 0.3 px (fx)  | else the test would not see a correction     |
#include "calib/solve/circle_bias.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calib/solve/calibrate.hpp"
#include "tests/support/calib/calib_rig.hpp"

namespace fringetwin::calib::circle_bias_test {
namespace {

constexpr double kRadiusMm = 4.5;

Pose tilted(double tx, double ty, double z) {
  return {(Eigen::AngleAxisd(tx, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(ty, Eigen::Vector3d::UnitY()))
              .toRotationMatrix(),
          {-20.0, 15.0, z}};
}

/// The dual of the circle, C* = [c c^T - r^2 (I, 0; 0, 0)] with c = (x, y, 1), goes to H C* H^T; its last
/// column is the centre of the ellipse.
Eigen::Vector2d ellipse_centre_px(const Eigen::Matrix3d& K, const Pose& T, const Eigen::Vector3d& c,
                                  double r) {
  Eigen::Matrix3d H;
  H << T.rotation.col(0), T.rotation.col(1), T.translation_mm;
  H = K * H;
  const Eigen::Vector3d at(c.x(), c.y(), 1.0);
  const Eigen::Matrix3d dual =
      at * at.transpose() - r * r * Eigen::Matrix3d(Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal());
  return Eigen::Vector3d((H * dual * H.transpose()).col(2)).hnormalized();
}

/// Shoelace centroid of the picture of the circle's outline.
Eigen::Vector2d outline_centroid_px(const Lens& lens, const Pose& T, const Eigen::Vector3d& c, double r) {
  constexpr int kSides = 4096;
  std::vector<Eigen::Vector2d> outline;
  for (int k = 0; k < kSides; ++k) {
    const double a = 2.0 * M_PI * k / kSides;
    outline.push_back(*lens.project(T * (c + r * Eigen::Vector3d(std::cos(a), std::sin(a), 0.0))));
  }
  const Eigen::Vector2d origin = outline[0];
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double area = 0.0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d p = outline[k] - origin, q = outline[(k + 1) % outline.size()] - origin;
    const double cross = p.x() * q.y() - q.x() * p.y();
    sum += cross * (p + q);
    area += cross;
  }
  return origin + sum / (3.0 * area);
}

TEST(CircleBias, CentroidIsTheEllipsesCentreInAPinhole) {
  const Lens lens("LENSMODEL_PINHOLE", {2000.0, 2010.0, 700.0, 500.0}, {1440, 1080}, "test");
  Eigen::Matrix3d K;
  K << 2000.0, 0.0, 700.0, 0.0, 2010.0, 500.0, 0.0, 0.0, 1.0;
  double largest = 0.0;
  for (const double tx : {-0.9, 0.0, 0.6})
    for (const double ty : {-0.5, 0.8})
      for (const double z : {200.0, 400.0}) {
        const Pose T = tilted(tx, ty, z);
        for (const Eigen::Vector3d& c : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(30.0, -20.0, 0)}) {
          const auto centroid = disc_centroid_px(lens, T, c, kRadiusMm);
          ASSERT_TRUE(centroid);
          const Eigen::Vector2d truth = ellipse_centre_px(K, T, c, kRadiusMm);
          EXPECT_LT((*centroid - truth).norm(), 1e-6) << tx << " " << ty << " " << z;
          largest = std::max(largest, (truth - *lens.project(T * c)).norm());
        }
      }
  EXPECT_GT(largest, 0.3);  // what is at stake
}

TEST(CircleBias, CentroidHoldsWithDistortion) {
  const Lens lens("LENSMODEL_OPENCV4", {2000.0, 2010.0, 700.0, 500.0, -0.25, 0.3, 0.002, -0.003},
                  {1440, 1080}, "test");
  for (const double tx : {-0.7, 0.5}) {
    const Pose T = tilted(tx, 0.4, 260.0);
    for (const Eigen::Vector3d& c : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(80.0, -50.0, 0)})
      EXPECT_LT(
          (*disc_centroid_px(lens, T, c, kRadiusMm) - outline_centroid_px(lens, T, c, kRadiusMm)).norm(),
          1e-5);
  }
}

/// The cameras see centroids; the projector is read where both see them, on the weighted average.
Observations circles(const testing::TrueRig& rig) {
  std::mt19937_64 random(9);
  testing::BoardDraw draw;
  draw.n_boards = 12;
  draw.sigma_px = 0.0;
  std::vector<Pose> boards;
  Observations o = testing::draw_observations(rig, random, draw, &boards);
  o.devices[2].is_projector = true;
  for (std::size_t f = 0; f < boards.size(); ++f)
    for (std::size_t i = 0; i < rig.board.corners(); ++i) {
      const Eigen::Vector3d c = rig.board.point_mm(i);
      Eigen::Vector2d read = Eigen::Vector2d::Zero();
      double weight = 0.0;
      for (std::size_t d = 0; d < 2; ++d) {
        const Pose T = rig.T_device_ref[d] * boards[f];
        const Eigen::Vector2d q = outline_centroid_px(rig.lenses[d], T, c, kRadiusMm);
        o.views[3 * f + d].corners[i].q_px = q;
        const Pose back = T.inverse();
        const Eigen::Vector3d along = back.rotation * *rig.lenses[d].unproject(q);
        const Eigen::Vector3d on_board = back.translation_mm - along * (back.translation_mm.z() / along.z());
        const double w = testing::reading_weight(rig, d, boards[f], c);
        read += w * *rig.lenses[2].project(rig.T_device_ref[2] * (boards[f] * on_board));
        weight += w;
      }
      o.views[3 * f + 2].corners[i].q_px = read / weight;
    }
  return o;
}

TEST(CircleBias, ARigIsFoundFromItsCirclesWhenTheyAreCorrected) {
  testing::TrueRig rig = testing::true_paper_rig();
  rig.warp_mm.setZero();
  const Observations o = circles(rig);
  CalibrateOptions options;
  options.regularize = options.reject_outliers = false;
  const Calibration biased = calibrate(o, options);
  options.reject_outliers = true;
  options.circle_diameter_mm = 2.0 * kRadiusMm;
  const Calibration c = calibrate(o, options);
  double largest_fx_error = 0.0;
  for (std::size_t d = 0; d < 3; ++d) {
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(c.devices[d].intrinsics[i], rig.lenses[d].intrinsics()[i], 1e-3) << d << " " << i;
    largest_fx_error =
        std::max(largest_fx_error, std::abs(biased.devices[d].intrinsics[0] - rig.lenses[d].intrinsics()[0]));
  }
  std::printf("corrections up to %.3f px; without them fx is %.3f px off, rms %.4f px instead of %.2g px\n",
              c.circle_correction_px, largest_fx_error, biased.fit.rms_px, c.fit.rms_px);
  EXPECT_GT(largest_fx_error, 0.3);
  EXPECT_LT(c.fit.rms_px, 1e-3);
}

}  // namespace
}  // namespace fringetwin::calib::circle_bias_test
