// SPDX-License-Identifier: Apache-2.0
// Tolerance: 6 %, the standard error of a variance over 2,000 draws is 3 %.
#include "compare/verdict/shape_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/QR>
#include <random>

#include "measure/depth_fit.hpp"

namespace fringetwin::compare::shape_noise_test {
namespace {

// White noise is drawn, smoothed by quadratics pixel by pixel (QR), and averaged over a square.
TEST(ShapeNoise, SharesAreThoseOfDrawnNoise) {
  constexpr int kRadius = 5, kRegion = 6, kSide = 2 * kRadius + kRegion, kDraws = 2000;
  const auto window = measure::window_of(kRadius);
  Eigen::MatrixXd design(static_cast<Eigen::Index>(window.size()), 6);
  for (std::size_t k = 0; k < window.size(); ++k) {
    const double x = window[k].dx, y = window[k].dy;
    design.row(static_cast<Eigen::Index>(k)) << 1.0, x, y, x * x, x * y, y * y;
  }
  const Eigen::MatrixXd response =
      design.colPivHouseholderQr().solve(Eigen::MatrixXd::Identity(design.rows(), design.rows()));
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  double depth = 0.0, slope = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::MatrixXd noise(kSide, kSide);
    for (double& value : noise.reshaped()) value = normal(random);
    double sum_depth = 0.0, sum_slope = 0.0;
    for (int y = kRadius; y < kRadius + kRegion; ++y)
      for (int x = kRadius; x < kRadius + kRegion; ++x)
        for (std::size_t k = 0; k < window.size(); ++k) {
          const double value = noise(y + window[k].dy, x + window[k].dx);
          sum_depth += response(0, static_cast<Eigen::Index>(k)) * value;
          sum_slope += response(1, static_cast<Eigen::Index>(k)) * value;
        }
    depth += sum_depth * sum_depth, slope += sum_slope * sum_slope;
  }
  const double n4 = static_cast<double>(kRegion * kRegion) * kRegion * kRegion;
  const RegionShares shares = region_shares(kRadius, kRegion);
  EXPECT_NEAR(shares.depth / (depth / kDraws / n4 / response.row(0).squaredNorm()), 1.0, 0.06);
  EXPECT_NEAR(shares.slope / (slope / kDraws / n4 / response.row(1).squaredNorm()), 1.0, 0.06);
}

TEST(ShapeNoise, WithoutAWindowEachPixelIsAlone) {
  EXPECT_DOUBLE_EQ(region_shares(0.0, 16).depth, 1.0 / 256.0);
}

}  // namespace
}  // namespace fringetwin::compare::shape_noise_test
