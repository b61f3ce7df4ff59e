// SPDX-License-Identifier: Apache-2.0
// Tolerance: 6 %, the standard error of a variance over 2,000 draws is 3 %.
#include "compare/shape/shape_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "measure/depth_fit.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare::shape_noise_test {
namespace {

/// Returns what the points of a window add to the value (row 0) and the slope along x (row 1) of a quadratic,
/// or of a plane, that is fitted to them.
Eigen::MatrixXd responses(const std::vector<measure::WindowOffset>& window) {
  Eigen::MatrixXd design(static_cast<Eigen::Index>(window.size()), 6);
  for (std::size_t k = 0; k < window.size(); ++k) {
    const double x = window[k].dx, y = window[k].dy;
    design.row(static_cast<Eigen::Index>(k)) << 1.0, x, y, x * x, x * y, y * y;
  }
  if (window.size() < 10) design = Eigen::MatrixXd(design.leftCols(3));  // a plane, as surfaces are fitted
  return design.colPivHouseholderQr().solve(Eigen::MatrixXd::Identity(design.rows(), design.rows()));
}

/// White noise is drawn, smoothed pixel by pixel (QR), and averaged over a square.
void expect_shares(double radius_px) {
  SCOPED_TRACE(radius_px);
  constexpr int kMargin = 5, kRegion = 6, kSide = 2 * kMargin + kRegion, kDraws = 2000;
  const auto window = measure::window_of(radius_px);
  const Eigen::MatrixXd response = responses(window);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  double depth = 0.0, slope = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::MatrixXd noise(kSide, kSide);
    for (double& value : noise.reshaped()) value = normal(random);
    double sum_depth = 0.0, sum_slope = 0.0;
    for (int y = kMargin; y < kMargin + kRegion; ++y)
      for (int x = kMargin; x < kMargin + kRegion; ++x)
        for (std::size_t k = 0; k < window.size(); ++k) {
          const double value = noise(y + window[k].dy, x + window[k].dx);
          sum_depth += response(0, static_cast<Eigen::Index>(k)) * value;
          sum_slope += response(1, static_cast<Eigen::Index>(k)) * value;
        }
    depth += sum_depth * sum_depth, slope += sum_slope * sum_slope;
  }
  const double n4 = static_cast<double>(kRegion * kRegion) * kRegion * kRegion;
  const RegionShares shares = region_shares(radius_px, kRegion);
  EXPECT_NEAR(shares.depth / (depth / kDraws / n4 / response.row(0).squaredNorm()), 1.0, 0.06);
  EXPECT_NEAR(shares.slope / (slope / kDraws / n4 / response.row(1).squaredNorm()), 1.0, 0.06);
}

// Windows of 5 and 9 points, which tell a plane, and of 13 and more, which tell a quadratic.
TEST(ShapeNoise, SharesAreThoseOfDrawnNoise) {
  for (const double radius_px : {1.0, 1.5, 2.0, 2.5, 5.0}) expect_shares(radius_px);
}

// White noise is drawn on a torus, smoothed in the same way, and summed up with a sine as weights.
TEST(ShapeNoise, RipplesAreThoseOfDrawnNoise) {
  constexpr int kRadius = 4, kSide = 24, kDraws = 1000;
  const auto window = measure::window_of(kRadius);
  const Eigen::MatrixXd response = responses(window);
  for (const double period_px : {24.0, 12.0, 6.0}) {
    std::mt19937_64 random(8);
    std::normal_distribution<double> normal(0.0, 1.0);
    double squares = 0.0;
    for (int draw = 0; draw < kDraws; ++draw) {
      Eigen::MatrixXd noise(kSide, kSide);
      for (double& value : noise.reshaped()) value = normal(random);
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();  // either has a variance of its own: 2000 values
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          double value = 0.0;
          for (std::size_t k = 0; k < window.size(); ++k)
            value += response(0, static_cast<Eigen::Index>(k)) *
                     noise((y + window[k].dy + kSide) % kSide, (x + window[k].dx + kSide) % kSide);
          const double at_rad = kTwoPi * x / period_px;
          sum += value * Eigen::Vector2d(std::cos(at_rad), std::sin(at_rad));
        }
      squares += sum.squaredNorm();
    }
    const double alone = kDraws * kSide * kSide * response.row(0).squaredNorm();
    EXPECT_NEAR(squares / alone / ripple_gain(kRadius, period_px), 1.0, 0.06) << period_px;
  }
}

TEST(ShapeNoise, WithoutAWindowEachPixelIsAlone) {
  EXPECT_DOUBLE_EQ(region_shares(0.0, 16).depth, 1.0 / 256.0);
}

/// A noise that moves three pixels by 0.1, 0.2 and nobody knows how many projector columns, in two cameras.
ShapeNoise noise_of_three(double steps_in_shape) {
  measure::SurfaceNoiseInView seen;
  seen.shading = ImageF(3, 1);
  seen.shading.data = {0.001F, 0.002F, std::numeric_limits<float>::quiet_NaN()};
  seen.moved_px = {seen.shading, seen.shading};
  for (ImageF& moved_px : seen.moved_px)
    for (float& value : moved_px.data) value *= 100.0F;
  seen.radius_px = seen.shading;
  seen.radius_px.data = {0.0F, 4.0F, std::numeric_limits<float>::quiet_NaN()};
  seen.median_shading = 0.005;
  seen.median_moved_px = {0.3, -0.4};
  ShapeNoise noise;
  noise.surface.radius_px = 3.0;
  noise.surface.of_camera = {seen, seen};
  noise.steps_in_shape = steps_in_shape;
  return noise;
}

TEST(ShapeNoise, APixelHasItsOwnAndOthersTheMedian) {
  const Twin twin;
  const ShapeNoise noise = noise_of_three(0.0);
  const ShapeInView view = shape_in_view(&noise, twin, 0, nullptr);
  EXPECT_FLOAT_EQ(static_cast<float>(view.moved_px_at(Axis::x, 1)), 0.2F);
  EXPECT_FLOAT_EQ(static_cast<float>(view.shading_at(1)), 0.002F);
  EXPECT_DOUBLE_EQ(view.shading_at(2), 0.005);
  EXPECT_DOUBLE_EQ(view.moved_px_at(Axis::x, 2), 0.3);
  EXPECT_DOUBLE_EQ(view.moved_px_at(Axis::y, 2), -0.4);
  // over the noise of a pixel's mean: of windows of one pixel that has 0.59375^2 of a vertex' variance
  EXPECT_NEAR(view.shares_at(0).depth, 1.0 / (kRegion * kRegion) / std::pow(0.59375, 2), 1e-12);
  EXPECT_EQ(view.radius_at(1), 40u);
  EXPECT_EQ(view.radius_at(2), 30u);
  ShapeInView owned = view;
  owned.shades = false;
  EXPECT_DOUBLE_EQ(owned.shading_at(1), 0.0) << "a factor per pixel holds it";
  EXPECT_GT(owned.moved_px_at(Axis::x, 1), 0.0);
  EXPECT_DOUBLE_EQ(ShapeInView{}.moved_px_at(Axis::x, 1), 0.0);
  EXPECT_DOUBLE_EQ(ShapeInView{}.shading_at(1), 0.0);
}

// The difference of the mean of N values and that of M among which a share of the N is varies by 1/M - 2
// share/M more than the mean of the N. Of two cameras whose depths move 0.3 and m px, the first one's values
// differ by n - 0.3 (n - n')/(0.3 - m): with the projector in the middle (m = -0.3) that is (n + n')/2, half
// of n alone; beyond the second camera (m = 0.1) it is -n/2 + 3 n'/2, 10/4 of it, of which the shape alone
// makes 18/4.
TEST(ShapeNoise, AShapeFollowsTheStepsThatItWasBuiltFrom) {
  Twin twin;
  double other_moves_px = 0.3;
  const auto moved_px = [&](double steps_in_shape, std::size_t camera) {
    ShapeNoise noise = noise_of_three(steps_in_shape);
    noise.surface.of_camera[0].median_moved_px = {0.3, 0.3};
    noise.surface.of_camera[1].median_moved_px = {other_moves_px, 0.6};
    return shape_in_view(&noise, twin, camera, nullptr).moved_px_at(Axis::x, 0);
  };
  twin.measure.triangulate = Triangulate::projector;
  EXPECT_FLOAT_EQ(static_cast<float>(moved_px(0.0, 0)), 0.1F);
  EXPECT_NEAR(moved_px(0.25, 0), 0.1 * std::sqrt(0.5), 1e-8);
  EXPECT_DOUBLE_EQ(moved_px(0.5, 0), 0.0);
  EXPECT_DOUBLE_EQ(moved_px(1.0, 0), 0.0);
  EXPECT_NE(moved_px(1.0, 1), 0.0) << "the other camera's noise is its own";
  twin.measure.triangulate = Triangulate::stereo;
  other_moves_px = -0.3;
  EXPECT_DOUBLE_EQ(moved_px(1.0, 0), 0.0) << "less than its own noise";
  EXPECT_DOUBLE_EQ(moved_px(1.0, 1), 0.0) << "its phases made the shape, too";
  other_moves_px = 0.1;
  EXPECT_NEAR(moved_px(1.0, 0), 0.1 * std::sqrt((10.0 - 4.0) / 18.0), 1e-8);
  EXPECT_NEAR(moved_px(1.0, 1), 0.1 * std::sqrt(1.0 + 2.0), 1e-8) << "it moves against its noise";
  ShapeNoise noise = noise_of_three(1.0);
  noise.surface.of_camera[1].median_moved_px = {-0.3, -0.2};  // of the first one's 0.3 and -0.4
  const ShapeInView first = shape_in_view(&noise, twin, 0, nullptr);
  EXPECT_DOUBLE_EQ(first.moved_px_at(Axis::x, 0), 0.0);
  EXPECT_NEAR(first.moved_px_at(Axis::y, 0), 0.1 * std::sqrt(0.5), 1e-8) << "each axis by itself";
}

}  // namespace
}  // namespace fringetwin::compare::shape_noise_test
