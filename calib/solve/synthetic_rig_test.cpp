// SPDX-License-Identifier: Apache-2.0
// The paper's rig (three devices) calibrated from synthetic corners with 0.1 px noise.
//
// | check                        | tolerance           | origin                            |
// |------------------------------|---------------------|-----------------------------------|
// | rms, per coordinate          | 0.0985 ± 0.003 px   | 0.1 sqrt(1 - states/measurements) |
// | outliers of 5 to 20 px       | all, at most 3 more | 5 sigma of 12000: 0.007 expected  |
// | rough focal lengths off by 2 | 1e-4 px             | the solver's stopping rule        |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calib/solve/calibrate.hpp"
#include "calib/solve/cross_validation.hpp"
#include "calib/solve/triangulate.hpp"
#include "calib/solve/uncertainty.hpp"
#include "tests/support/calib/calib_rig.hpp"

namespace fringetwin::calib::synthetic_rig_test {
namespace {

using testing::draw_observations;
using testing::shape_error_mm;

TEST(SyntheticRig, OneDraw) {
  const testing::TrueRig rig = testing::true_paper_rig();
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
  const testing::TrueRig rig = testing::true_paper_rig();
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
  const testing::TrueRig rig = testing::true_paper_rig();
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
  const testing::TrueRig rig = testing::true_paper_rig();
  CalibrateOptions options;
  options.regularize = false;
  const Calibration c = calibrate(draw_observations(rig, random, draw), options);
  EXPECT_LT(c.fit.n_outliers, 60);
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(c.devices[d].intrinsics[i], rig.lenses[d].intrinsics()[i], 1e-3);
}

TEST(SyntheticRig, EvenAgainstOdd) {
  std::mt19937_64 random(6);
  const Calibration c = calibrate(draw_observations(testing::true_paper_rig(), random), {});
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
}  // namespace fringetwin::calib::synthetic_rig_test
