// SPDX-License-Identifier: Apache-2.0
// tolerance         unit  origin
// 1e-11*scale/2000  px    closed form against libmrcal: 22 roundings of 2.2e-16 at coordinates of `scale`
// 1e-9              px    the promise of unproject()
// 1e-8 * f          px    Jacobian against central differences, step 1e-6: rounding 5e-13 px / 2e-6 = 2.5e-7
// px
//                         (f = 2000: 1.3e-10 f), truncation f h^2 f''' / 6, f''' up to 1e3 for strong lenses
// 1e-12             -     Jacobian against libmrcal's, relative to f (rounding)
#include "twin/lens/lens.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/support/twin/random_lenses.hpp"
#include "twin/lens/mrcal_facade.hpp"

namespace fringetwin::lens_test {
namespace {

using testing::any_lens;
using testing::any_pixel;
using testing::uniform;

double scale_px(const Lens& lens) {
  double scale = std::max(lens.width(), lens.height());
  for (int i = 0; i < 4; ++i)
    scale = std::max(scale, std::abs(lens.intrinsics()[static_cast<std::size_t>(i)]));
  return scale;
}

TEST(Lens, PinholeByHand) {
  const Lens lens("LENSMODEL_PINHOLE", {1000, 1100, 320, 240}, {640, 480}, "test");
  const auto q = lens.project({0.1, -0.2, 2.0});
  ASSERT_TRUE(q);
  EXPECT_NEAR(q->x(), 370.0, 1e-12);
  EXPECT_NEAR(q->y(), 130.0, 1e-12);
  const auto v = lens.unproject({370.0, 130.0});
  ASSERT_TRUE(v);
  EXPECT_LT((*v - Eigen::Vector3d(0.1, -0.2, 2.0).normalized()).norm(), 1e-15);
  EXPECT_TRUE(lens.is_perspective());
  EXPECT_EQ(lens.opencv_distortion(), (Eigen::Matrix<double, 12, 1>::Zero()));
  EXPECT_TRUE(std::isinf(lens.max_invertible_radius_sq()));
}

TEST(Lens, OpenCv12ByTheFormula) {
  // x = 0.5, y = 0.25 (r^2 = 0.3125), all coefficients different
  const std::vector<double> k{0.1,   -0.02,  0.003, -0.004, 0.005,  0.06,
                              0.007, -0.008, 0.009, 0.01,   -0.011, 0.012};
  std::vector<double> intrinsics{1000, 1000, 500, 400};
  intrinsics.insert(intrinsics.end(), k.begin(), k.end());
  const Lens lens("LENSMODEL_OPENCV12", intrinsics, {1000, 800}, "test");
  const long double x = 0.5L, y = 0.25L, r2 = 0.3125L, r4 = r2 * r2, r6 = r4 * r2;
  const long double radial =
      (1 + 0.1L * r2 - 0.02L * r4 + 0.005L * r6) / (1 + 0.06L * r2 + 0.007L * r4 - 0.008L * r6);
  const long double xd =
      x * radial + 2 * 0.003L * x * y - 0.004L * (r2 + 2 * x * x) + 0.009L * r2 + 0.01L * r4;
  const long double yd =
      y * radial + 0.003L * (r2 + 2 * y * y) - 2 * 0.004L * x * y - 0.011L * r2 + 0.012L * r4;
  const auto q = lens.project({1.0, 0.5, 2.0});
  ASSERT_TRUE(q);
  EXPECT_NEAR(q->x(), static_cast<double>(1000 * xd + 500), 1e-11);
  EXPECT_NEAR(q->y(), static_cast<double>(1000 * yd + 400), 1e-11);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(lens.opencv_distortion()[i], k[static_cast<std::size_t>(i)]);
}

TEST(Lens, DistortionIsZeroPadded) {
  const Lens lens = testing::paper_left();
  EXPECT_EQ(lens.opencv_distortion()[3], -0.0004);
  EXPECT_EQ(lens.opencv_distortion().tail<8>(), (Eigen::Matrix<double, 8, 1>::Zero()));
  EXPECT_EQ(lens.model(), "LENSMODEL_OPENCV4");
  EXPECT_EQ(lens.width(), 1440);
  EXPECT_EQ(lens.height(), 1080);
}

TEST(Lens, PaperRigRoundTripsOverTheWholeImage) {
  for (const Lens& lens : {testing::paper_left(), testing::paper_right(), testing::paper_projector()}) {
    double worst_px = 0.0;
    for (double y = -0.5; y <= lens.height() - 0.5; y += 7.5) {
      for (double x = -0.5; x <= lens.width() - 0.5; x += 7.5) {
        const auto v = lens.unproject({x, y});
        ASSERT_TRUE(v) << x << " " << y;
        const auto q = lens.project(*v * 270.0);
        ASSERT_TRUE(q);
        worst_px = std::max(worst_px, (*q - Eigen::Vector2d(x, y)).norm());
      }
    }
    EXPECT_LT(worst_px, 1e-9);
    RecordProperty("worst_round_trip_px", std::to_string(worst_px));
  }
}

TEST(Lens, PublishedWideOpenCv8RoundTrips) {
  // A real calibration of mrcal's documentation (6016x4016, 86 degrees off axis in the corners).
  const Lens lens("LENSMODEL_OPENCV8",
                  {2073.87291548, 2077.45226676, 3004.68682279, 1997.37725296, 0.479161379745,
                   0.0266824914005, 4.398264387e-05, -1.18007391311e-05, 8.95972254248e-05, 0.766691246927,
                   0.0963356123128, 0.00140751331341},
                  {6016, 4016}, "published");
  for (double y = -0.5; y <= 4015.5; y += 50.2) {
    for (double x = -0.5; x <= 6015.5; x += 50.13) {
      const auto v = lens.unproject({x, y});
      ASSERT_TRUE(v);
      EXPECT_LT((*lens.project(*v) - Eigen::Vector2d(x, y)).norm(), 1e-9);
    }
  }
}

TEST(Lens, BehindTheCameraAndBadPointsHaveNoPixel) {
  const Lens lens = testing::paper_left();
  const double nan = std::nan(""), inf = INFINITY;
  EXPECT_FALSE(lens.project({0, 0, -1}));
  EXPECT_FALSE(lens.project({0, 0, 0}));
  EXPECT_FALSE(lens.project({1, 1, 0}));
  EXPECT_FALSE(lens.project({nan, 0, 1}));
  EXPECT_FALSE(lens.project({0, 0, nan}));
  EXPECT_FALSE(lens.project({inf, 0, inf}));
  EXPECT_FALSE(lens.unproject({nan, 0}));
  EXPECT_FALSE(lens.unproject({0, inf}));
  EXPECT_TRUE(lens.project({0, 0, 1e-300}));
}

TEST(Lens, ProjectionDoesNotDependOnTheUnit) {
  const Lens lens = testing::paper_projector();
  const Eigen::Vector3d p_mm(30.0, -20.0, 270.0);
  EXPECT_LT((*lens.project(p_mm) - *lens.project(p_mm * 1e-3)).norm(), 1e-12);
}

RC_GTEST_PROP(LensProperty, ClosedFormEqualsLibmrcal, ()) {
  const Lens lens = any_lens();
  const auto v = lens.unproject(any_pixel(lens));
  RC_ASSERT(v.has_value());
  const Eigen::Vector3d p = *v * *uniform(0.1, 2000.0);
  Eigen::Matrix<double, 2, 3> J, J_mrcal;
  const auto q = lens.project(p, &J);
  RC_ASSERT(q.has_value());
  Eigen::Vector2d q_mrcal;
  RC_ASSERT(MrcalModel::from_name(lens.model())->project(lens.intrinsics(), p, &q_mrcal, &J_mrcal));
  RC_ASSERT((*q - q_mrcal).norm() < 1e-11 * scale_px(lens) / 2000.0);
  RC_ASSERT((J - J_mrcal).cwiseAbs().maxCoeff() * p.norm() < 1e-12 * scale_px(lens));
  RC_ASSERT(*lens.project(p) == *q);
}

RC_GTEST_PROP(LensProperty, ProjectUndoesUnproject, ()) {
  const Lens lens = any_lens();
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d q = any_pixel(lens);
    const auto v = lens.unproject(q);
    RC_ASSERT(v.has_value());
    RC_ASSERT(std::abs(v->norm() - 1.0) < 4e-16);
    const auto back = lens.project(*v * *uniform(0.1, 2000.0));
    RC_ASSERT(back.has_value());
    RC_ASSERT((*back - q).norm() < 1e-9);
  }
}

RC_GTEST_PROP(LensProperty, UnprojectAgreesWithLibmrcal, ()) {
  const Lens lens = any_lens();
  const Eigen::Vector2d q = any_pixel(lens);
  Eigen::Vector3d v_mrcal;
  RC_ASSERT(MrcalModel::from_name(lens.model())->unproject(lens.intrinsics(), q, &v_mrcal));
  const auto v = lens.unproject(q);
  RC_ASSERT(v.has_value());
  // libmrcal stops at a squared error of 1e-4 px^2 at the latest; the derivative of the map is >= 0.1 here
  RC_ASSERT((*v - v_mrcal.normalized()).norm() < 1e-2 / (0.1 * lens.intrinsics()[0]));
}

RC_GTEST_PROP(LensProperty, JacobianEqualsCentralDifferences, ()) {
  const Lens lens = any_lens();
  const auto v = lens.unproject(any_pixel(lens));
  RC_ASSERT(v.has_value());
  const Eigen::Vector3d p = *v / v->z();
  Eigen::Matrix<double, 2, 3> J;
  RC_ASSERT(lens.project(p, &J).has_value());
  constexpr double h = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
    const auto ahead = lens.project(p + step), behind = lens.project(p - step);
    if (!ahead || !behind) RC_DISCARD("at the border of the domain");
    const Eigen::Vector2d difference = (*ahead - *behind) / (2 * h);
    RC_ASSERT((J.col(axis) - difference).norm() < 1e-8 * scale_px(lens));
  }
}

}  // namespace
}  // namespace fringetwin::lens_test
