// SPDX-License-Identifier: Apache-2.0
// The paper's rig (three devices) calibrated from synthetic corners with 0.1 px noise.
//
// | check                                   | tolerance    | unit | origin |
// |-----------------------------------------|--------------|------|-----------------------------------------------------|
// | rms, per coordinate                     | 0.0985±0.003 | px   | 0.1 sqrt(1 - states/measurements); 1 /
// sqrt(2 n)    | | 40 draws: rms error of fx               | 0.30         | px   | 0.25 for a correct joint
// solve, ± 11 % (1/sqrt(80)) | | 40 draws: shape, L+R and L+P            | 0.0025 0.0040| mm   | 0.0020 and
// 0.0032 (as above)                        | | 40 draws: scatter / predicted           | 1 ± 0.34     | | 3
// standard errors of an rms of 40                   | | outliers of 5 … 20 px                   | all, ≤ 3
// more|      | 5 sigma of 12000: 0.007 expected                    | | focal lengths wrong by a factor of 2
// | 1e-4         | px   | the same minimum, to the solver's stopping rule     |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calib/cross_validation.hpp"
#include "calib/rig_testing.hpp"
#include "calib/triangulate.hpp"
#include "calib/uncertainty.hpp"

namespace fringetwin::calib {
namespace {

using testing::draw_observations;

struct Rms {
  double sum = 0.0;
  int n = 0;
  void add(double v) { sum += v * v, ++n; }
  double value() const { return std::sqrt(sum / n); }
};

/// Points of the volume that all devices see.
std::vector<Eigen::Vector3d> volume(const testing::TrueRig& rig) {
  std::vector<Eigen::Vector3d> points;
  for (const double z : {250.0, 280.0, 310.0})
    for (int i = -3; i <= 3; ++i)
      for (int j = -3; j <= 3; ++j) {
        const Eigen::Vector3d p(12.0 * i, 10.0 * j, z);
        bool seen = true;
        for (std::size_t d = 0; d < 3; ++d) {
          const auto q = rig.lenses[d].project(rig.T_device_ref[d] * p);
          seen = seen && q && q->minCoeff() > 0.0 && q->x() < rig.lenses[d].width() - 1 &&
                 q->y() < rig.lenses[d].height() - 1;
        }
        if (seen) points.push_back(p);
      }
  return points;
}

/// rms of the shape that devices 0 and `other` measure, when the pixels are the true rig's.
double shape_error_mm(const testing::TrueRig& rig, const Calibration& c, std::size_t other) {
  const std::vector<Eigen::Vector3d> truth = volume(rig);
  std::vector<Eigen::Vector3d> measured;
  for (const auto& p : truth) {
    std::vector<Eigen::Vector2d> q;
    for (const std::size_t d : {std::size_t{0}, other})
      q.push_back(*rig.lenses[d].project(rig.T_device_ref[d] * p));
    measured.push_back(*triangulate({c.lens(0), c.lens(static_cast<int>(other))},
                                    {Pose{}, c.devices[other].T_device_ref}, q, p));
  }
  return aligned_rms_mm(measured, truth);
}

TEST(SyntheticRig, OneDraw) {
  const testing::TrueRig rig = testing::paper_rig();
  std::mt19937_64 random(1);
  Observations o = draw_observations(rig, random);
  const Calibration c = calibrate(o, {});
  EXPECT_NEAR(c.fit.rms_component_px, 0.0985, 0.003);
  EXPECT_NEAR(c.fit.rms_px, std::sqrt(2.0) * c.fit.rms_component_px, 1e-12);
  EXPECT_EQ(c.fit.n_corners, 6000);
  EXPECT_NEAR(c.warp_mm.x(), rig.warp_mm.x(), 0.01);
  EXPECT_NEAR(c.warp_mm.y(), rig.warp_mm.y(), 0.01);
  EXPECT_TRUE(c.warnings.empty());
  // Other rough focal lengths, another order of the views, metres of another board frame: the same minimum.
  o.devices[0].focal_px = 1200.0;
  o.devices[1].focal_px = 4700.0;
  o.devices[2].focal_px = 3400.0;
  std::reverse(o.views.begin(), o.views.end());
  const Calibration again = calibrate(o, {});
  for (std::size_t d = 0; d < 3; ++d)
    EXPECT_NEAR(again.devices[d].intrinsics[0], c.devices[d].intrinsics[0], 1e-4);
}

TEST(SyntheticRig, PartialViewsAndOtherModels) {
  const testing::TrueRig rig = testing::paper_rig();
  std::mt19937_64 random(2);
  testing::BoardDraw draw;
  draw.least_corners = 50;
  const Observations o = draw_observations(rig, random, draw);
  for (const char* model : {"LENSMODEL_OPENCV4", "LENSMODEL_OPENCV5", "LENSMODEL_OPENCV8",
                            "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=8_fov_x_deg=44"}) {
    CalibrateOptions options;
    options.lensmodel = model;
    const Calibration c = calibrate(o, options);
    EXPECT_LT(c.fit.n_corners, 6000);
    EXPECT_NEAR(c.fit.rms_component_px, 0.0975, 0.004) << model;
    EXPECT_LT(shape_error_mm(rig, c, 1), 0.015) << model;
  }
}

TEST(SyntheticRig, OutliersAndANoisyProjector) {
  const testing::TrueRig rig = testing::paper_rig();
  std::mt19937_64 random(3);
  Observations o = draw_observations(rig, random);
  std::normal_distribution<double> noise(0.0, 0.39);
  std::uniform_real_distribution<double> size(5.0, 20.0);
  std::vector<std::pair<std::size_t, std::size_t>> planted;
  for (std::size_t v = 0; v < o.views.size(); ++v) {
    if (v % 3 == 2)
      for (Corner& corner : o.views[v].corners) corner.q_px += Eigen::Vector2d(noise(random), noise(random));
    for (const std::size_t i : {(7 * v + 3) % 80}) {
      o.views[v].corners[i].q_px.x() += size(random);
      planted.emplace_back(v, i);
    }
  }
  o.devices[2].sigma_px = 4.0;
  const Calibration c = calibrate(o, {});
  int found = 0;
  for (const auto& [v, i] : planted) found += c.is_outlier(v, i);
  EXPECT_EQ(found, 75);
  EXPECT_LE(c.fit.n_outliers, 78);
  EXPECT_LT(shape_error_mm(rig, c, 1), 0.008);
}

TEST(SyntheticRig, NoiseFreeKeepsItsCorners) {
  std::mt19937_64 random(4);
  testing::BoardDraw draw;
  draw.sigma_px = 0.0;
  const testing::TrueRig rig = testing::paper_rig();
  CalibrateOptions options;
  options.regularize = false;
  const Calibration c = calibrate(draw_observations(rig, random, draw), options);
  EXPECT_LT(c.fit.n_outliers, 60);
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(c.devices[d].intrinsics[i], rig.lenses[d].intrinsics()[i], 1e-3);
}

TEST(SyntheticRig, FortyDrawsScatterAsPredicted) {
  const testing::TrueRig rig = testing::paper_rig();
  const std::vector<Eigen::Vector3d> points = volume(rig);
  std::mt19937_64 random(5);
  CalibrateOptions options;
  options.regularize = false;
  Rms fx[3], fx_sigma[3], translation[2], translation_sigma[2], shape[2], shape_sigma[2];
  constexpr int kDraws = 40;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Calibration c = calibrate(draw_observations(rig, random), options);
    const Uncertainty uncertainty(c);
    for (int d = 0; d < 3; ++d) {
      fx[d].add(c.devices[static_cast<std::size_t>(d)].intrinsics[0] -
                rig.lenses[static_cast<std::size_t>(d)].intrinsics()[0]);
      fx_sigma[d].add(std::sqrt(uncertainty.intrinsics(d)(0, 0)));
    }
    for (int d = 1; d < 3; ++d) {
      const auto k = static_cast<std::size_t>(d);
      const Eigen::Vector3d error =
          c.devices[k].T_device_ref.translation_mm - rig.T_device_ref[k].translation_mm;
      translation[d - 1].add(error.norm());
      translation_sigma[d - 1].add(std::sqrt(uncertainty.extrinsics(d).bottomRightCorner<3, 3>().trace()));
      shape[d - 1].add(shape_error_mm(rig, c, k));
      shape_sigma[d - 1].add(aligned_shape_sigma_mm(points, uncertainty.points(points, {{0}, {d}})));
    }
  }
  constexpr double kThreeErrors = 0.34;  // 3 / sqrt(2 * 40)
  for (int d = 0; d < 3; ++d) {
    std::printf("fx of device %d: scatter %.3f px, predicted %.3f px\n", d, fx[d].value(),
                fx_sigma[d].value());
    EXPECT_LE(fx[d].value(), 0.30);
    EXPECT_NEAR(fx[d].value() / fx_sigma[d].value(), 1.0, kThreeErrors);
  }
  for (int k = 0; k < 2; ++k) {
    std::printf("t of device %d: scatter %.4f mm, predicted %.4f; shape %.5f mm, predicted %.5f\n", k + 1,
                translation[k].value(), translation_sigma[k].value(), shape[k].value(),
                shape_sigma[k].value());
    EXPECT_NEAR(translation[k].value() / translation_sigma[k].value(), 1.0, kThreeErrors);
    EXPECT_NEAR(shape[k].value() / shape_sigma[k].value(), 1.0, kThreeErrors);
  }
  EXPECT_LE(shape[0].value(), 0.0025);
  EXPECT_LE(shape[1].value(), 0.0040);
}

TEST(SyntheticRig, EvenAgainstOdd) {
  std::mt19937_64 random(6);
  const Calibration c = calibrate(draw_observations(testing::paper_rig(), random), {});
  const CrossValidation v = cross_validate(c, {});
  ASSERT_EQ(v.not_done, "");
  EXPECT_EQ(v.n_even, 13);
  EXPECT_EQ(v.n_odd, 12);
  ASSERT_EQ(v.devices.size(), 3u);
  for (const auto& d : v.devices) {
    // The rigid motion that is taken out absorbs a part of what is expected.
    EXPECT_GT(d.relative, 0.05);
    EXPECT_LT(d.relative, 2.0);
    EXPECT_LT(d.rms_px, 0.3);
    EXPECT_GE(d.max_px, d.rms_px);
  }
  EXPECT_LT(v.shape_rms_mm, 0.02);
  EXPECT_GT(v.shape_rms_mm, 1e-4);
}

}  // namespace
}  // namespace fringetwin::calib
