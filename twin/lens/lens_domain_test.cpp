// SPDX-License-Identifier: Apache-2.0
// tolerance  unit      origin
// 1e-12      relative  a simple polynomial root, against its closed form: rounding times its condition (<
// 1e3) 2e-6       relative  the radius of the domain, which is shrunk by 1e-6 1e-9       px        the
// promise of unproject()
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "tests/support/twin/random_lenses.hpp"
#include "twin/lens/opencv_distortion.hpp"
#include "twin/number/polynomial.hpp"

namespace fringetwin::lens_domain_test {
namespace {

using ::testing::HasSubstr;
using testing::uniform;

// ------------------------------------------------------------ roots

TEST(Polynomial, SmallestOfThreeRoots) {  // (x-1)(x-2)(x-3)
  EXPECT_NEAR(*smallest_positive_root({-6, 11, -6, 1}, 1e6), 1.0, 1e-12);
  EXPECT_NEAR(*smallest_positive_root({6, 11, 6, -1}, 1e6), 7.5, 0.1);  // x^3 = 6x^2 + 11x + 6
}

TEST(Polynomial, NoPositiveRoot) {
  EXPECT_FALSE(smallest_positive_root({1, 0, 1}, 1e6));
  EXPECT_FALSE(smallest_positive_root({1, 1}, 1e6));
  EXPECT_FALSE(smallest_positive_root({1}, 1e6));
  EXPECT_FALSE(smallest_positive_root({1, 0, 0}, 1e6));
  EXPECT_FALSE(smallest_positive_root({}, 1e6));
}

TEST(Polynomial, TouchingRootCounts) {  // (x-1)^2, (x-1/3)^4
  EXPECT_NEAR(*smallest_positive_root({1, -2, 1}, 1e6), 1.0, 1e-9);
  const Polynomial square = multiply({-1.0 / 3, 1}, {-1.0 / 3, 1});
  EXPECT_NEAR(*smallest_positive_root(multiply(square, square), 1e6), 1.0 / 3, 1e-3);  // rounding^(1/4)
}

TEST(Polynomial, RootsBeyondTheLimitDoNotCount) { EXPECT_FALSE(smallest_positive_root({-2e6, 1}, 1e6)); }

RC_GTEST_PROP(PolynomialProperty, FindsTheSmallestOfGivenRoots, ()) {
  Polynomial p{1.0};
  double smallest = INFINITY;
  double place = *uniform(0.1, 0.5);
  for (int i = 0; i < 4; ++i, place += *uniform(0.2, 1.0)) {
    const double root = *rc::gen::element(-1.0, 1.0) * place;
    p = multiply(p, {-root, 1.0});
    if (root > 0) smallest = std::min(smallest, root);
  }
  p = multiply(p, {2.0, 0.0, 1.0});  // two complex roots
  const auto found = smallest_positive_root(p, 1e6);
  RC_ASSERT(found.has_value() == std::isfinite(smallest));
  if (found) RC_ASSERT(std::abs(*found - smallest) < 1e-10);
}

// ------------------------------------------------------------ domain

OpenCvDistortion coefficients(std::initializer_list<double> k) {
  OpenCvDistortion all = OpenCvDistortion::Zero();
  std::copy(k.begin(), k.end(), all.data());
  return all;
}

TEST(Domain, RadialLimitInClosedForm) {  // 1 + 3 k1 u + 5 k2 u^2 = 0
  const double k1 = 0.1328, k2 = -0.3361;
  const double u = (3 * k1 + std::sqrt(9 * k1 * k1 - 20 * k2)) / (-10 * k2);
  EXPECT_NEAR(max_invertible_radius(coefficients({k1, k2})), std::sqrt(u), 1e-12);
  EXPECT_NEAR(std::sqrt(u), 0.9482, 1e-4);
}

TEST(Domain, BarrelAloneEndsAtOneOverRootThreeK) {
  EXPECT_NEAR(max_invertible_radius(coefficients({-0.8})), 1.0 / std::sqrt(2.4), 1e-12);
}

TEST(Domain, RationalModelEndsAtItsPoleOrItsFold) {
  // r / (1 - r^2): monotone up to the pole at 1
  EXPECT_NEAR(max_invertible_radius(coefficients({0, 0, 0, 0, 0, -1.0})), 1.0, 1e-12);
  // r / (1 + r^2): folds at 1
  EXPECT_NEAR(max_invertible_radius(coefficients({0, 0, 0, 0, 0, 1.0})), 1.0, 1e-7);
  // r (1 + r^2) / (1 + r^2) = r: no limit
  EXPECT_TRUE(std::isinf(max_invertible_radius(coefficients({0.7, 0, 0, 0, 0, 0.7}))));
}

TEST(Domain, TangentialTermsAloneEndAtOneOverSixP) {
  EXPECT_NEAR(max_invertible_radius(coefficients({0, 0, 3e-4, 4e-4})), 1.0 / (6 * 5e-4), 1e-9);
}

TEST(Domain, PaperRig) {
  EXPECT_TRUE(std::isinf(testing::paper_left().max_invertible_radius_sq()));
  EXPECT_TRUE(std::isinf(testing::paper_right().max_invertible_radius_sq()));
  const double r = std::sqrt(testing::paper_projector().max_invertible_radius_sq());
  EXPECT_LT(r, 0.9482);  // tangential terms cost a little
  EXPECT_GT(r, 0.945);
}

OpenCvDistortion any_distortion() {
  const double limits[12] = {0.6, 0.5, 0.02, 0.02, 0.3, 0.5, 0.3, 0.1, 0.05, 0.05, 0.05, 0.05};
  OpenCvDistortion k;
  for (int i = 0; i < 12; ++i) k[i] = *uniform(-limits[i], limits[i]);
  return k;
}

Eigen::Vector2d any_point_in_disk(double radius) {
  const double r = radius * std::sqrt(*uniform(0.0, 0.999999)), a = *uniform(0.0, 2 * std::numbers::pi);
  return {r * std::cos(a), r * std::sin(a)};
}

RC_GTEST_PROP(DomainProperty, OneToOneWithPositiveDeterminantInside, ()) {
  const OpenCvDistortion k = any_distortion();
  const double radius = std::min(max_invertible_radius(k), 3.0);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d a = any_point_in_disk(radius), b = any_point_in_disk(radius);
    Eigen::Matrix2d J;
    const Eigen::Vector2d difference = distort(k, a, &J) - distort(k, b);
    RC_ASSERT(J.determinant() > 0.0);
    // a monotone map: no two points can have the same image
    if (a != b) RC_ASSERT(difference.dot(a - b) > 0.0);
  }
}

RC_GTEST_PROP(DomainProperty, RadialMapFoldsJustOutside, ()) {
  OpenCvDistortion k = any_distortion();
  k[2] = k[3] = 0.0;
  k.tail<4>().setZero();
  const double radius = max_invertible_radius(k);
  if (!std::isfinite(radius)) return;
  Eigen::Matrix2d inside, outside;
  distort(k, {radius * (1 - 1e-3), 0.0}, &inside);
  distort(k, {radius * (1 + 1e-3), 0.0}, &outside);
  RC_ASSERT(inside.determinant() > 0.0);
  // past a fold the determinant is negative; past a pole the denominator is
  const double u = radius * radius * (1 + 2e-3);
  const double denominator = 1 + u * (k[5] + u * (k[6] + u * k[7]));
  RC_ASSERT(outside.determinant() < 0.0 || denominator < 0.0);
}

// ------------------------------------------------------------ refusals

std::string refusal(const std::string& model, const std::vector<double>& intrinsics,
                    const Eigen::Vector2i& size) {
  try {
    const Lens lens(model, intrinsics, size, "twin.toml:12: camera 'left'");
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    return e.what();
  }
  return "";
}

TEST(Refusal, StrongBarrelOnAWideLens) {  // corners at 38 degrees, fold at 32.8
  const std::string text = refusal("LENSMODEL_OPENCV4", {800, 800, 639.5, 359.5, -0.8, 0, 0, 0}, {1280, 720});
  EXPECT_THAT(text, HasSubstr("twin.toml:12: camera 'left'"));
  EXPECT_THAT(text, HasSubstr("cannot be inverted at image point (-0.5, -0.5)"));
  EXPECT_THAT(text, HasSubstr("32.84 deg"));
}

TEST(Refusal, TheSameDistortionOnANarrowLensIsFine) {
  EXPECT_EQ(refusal("LENSMODEL_OPENCV4", {3000, 3000, 639.5, 359.5, -0.8, 0, 0, 0}, {1280, 720}), "");
}

TEST(Refusal, ImageJustInsideAndJustOutsideTheDomain) {
  // the fold of k1 = -0.8 lies at distorted radius r (1 - 0.8 r^2) = 2/3 r = 0.430331
  const double r_d = 2.0 / 3.0 / std::sqrt(2.4);
  const double corner_px = std::hypot(640.0, 360.0);
  const auto lens = [&](double f) {
    return refusal("LENSMODEL_OPENCV4", {f, f, 639.5, 359.5, -0.8, 0, 0, 0}, {1280, 720});
  };
  EXPECT_EQ(lens(corner_px / r_d * (1 + 1e-9)), "");
  EXPECT_NE(lens(corner_px / r_d * (1 - 1e-9)), "");
}

TEST(Refusal, BadValues) {
  const auto pinhole = [](double fx, double fy, int w, int h) {
    return refusal("LENSMODEL_PINHOLE", {fx, fy, 10, 10}, {w, h});
  };
  EXPECT_THAT(pinhole(-1, 100, 20, 20), HasSubstr("focal lengths must be positive"));
  EXPECT_THAT(pinhole(100, 0, 20, 20), HasSubstr("focal lengths must be positive"));
  EXPECT_THAT(pinhole(std::nan(""), 100, 20, 20), HasSubstr("intrinsics[0] is not finite"));
  EXPECT_THAT(pinhole(100, INFINITY, 20, 20), HasSubstr("intrinsics[1] is not finite"));
  EXPECT_THAT(pinhole(100, 100, 0, 20), HasSubstr("imagersize must be positive, is 0 x 20 px"));
  EXPECT_THAT(refusal("LENSMODEL_OPENCV5", {100, 100, 10, 10, 0, 0, 0, 0}, {20, 20}),
              HasSubstr("LENSMODEL_OPENCV5 takes 9 intrinsics, 8 given"));
  EXPECT_THAT(refusal("OPENCV4", {100, 100, 10, 10, 0, 0, 0, 0}, {20, 20}),
              HasSubstr("unknown lens model 'OPENCV4'"));
  EXPECT_THAT(refusal("LENSMODEL_SPLINED_STEREOGRAPHIC", {100, 100, 10, 10}, {20, 20}),
              HasSubstr("unknown lens model"));
  EXPECT_THAT(refusal("LENSMODEL_CAHVORE_linearity=0.34", {100, 100, 10, 10, 0, 0, 0, 0}, {20, 20}),
              HasSubstr("takes 12 intrinsics, 8 given"));
  EXPECT_THAT(pinhole(1e300, 100, 20, 20), HasSubstr("intrinsics[0] must be at most 1000000000 in size"));
  EXPECT_THAT(pinhole(100, 1e-4, 20, 20), HasSubstr("focal lengths must be at least 0.001"));
  EXPECT_THAT(pinhole(100, 100, 60000, 60000), HasSubstr("must be at most 2e+08 pixels in all"));
}

TEST(Outside, PointsBeyondTheDomainHaveNoPixelAndPixelsBeyondTheImageOfItNoDirection) {
  const Lens projector = testing::paper_projector();
  const double r = std::sqrt(projector.max_invertible_radius_sq());
  EXPECT_TRUE(projector.project({r * (1 - 1e-9), 0, 1}));
  EXPECT_FALSE(projector.project({r * (1 + 1e-9), 0, 1}));
  EXPECT_FALSE(projector.project({0.7, 0.7, 1}));
  // its largest distorted radius is 0.8038
  EXPECT_TRUE(projector.unproject({627.73 + 0.79 * 1700.15, 406.54}));
  EXPECT_FALSE(projector.unproject({627.73 + 0.81 * 1700.15, 406.54}));
  EXPECT_FALSE(projector.unproject({1e6, -1e6}));
  EXPECT_FALSE(projector.unproject({1e300, 1e300}));
}

TEST(Outside, PixelsNextToTheFoldStillRoundTrip) {
  const Lens projector = testing::paper_projector();
  for (int i = 0; i < 360; ++i) {
    const double a = i * std::numbers::pi / 180,
                 r = std::sqrt(projector.max_invertible_radius_sq()) * (1 - 1e-7);
    const Eigen::Vector2d q = *projector.project({r * std::cos(a), r * std::sin(a), 1.0});
    const auto v = projector.unproject(q);
    if (!v) continue;  // the last rounding may fall outside
    EXPECT_LT((*projector.project(*v) - q).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace fringetwin::lens_domain_test
