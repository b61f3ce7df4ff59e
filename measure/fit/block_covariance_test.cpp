// SPDX-License-Identifier: Apache-2.0
// The jackknife over blocks against closed forms. 1e-14: rounding of sums of a few terms.
#include "measure/fit/block_covariance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace fringetwin::measure::block_covariance_test {
namespace {

constexpr int kBlocks = 20, kPoints = 50;

/// Blocks of equal points that share an error each: -9.5, -8.5 ... 9.5.
double shared_error(int block) { return block - 0.5 * (kBlocks - 1); }

/// One over G (G - 1) times the sum of squares of G errors in steps of 1 (sum: G (G^2 - 1)/12).
constexpr double kVarianceOfMean = (kBlocks + 1) / 12.0;

// The fit of a constant: its variance is that of a mean over the blocks, s^2/G.
TEST(BlockCovariance, OfAMeanIsThatOfTheBlocksMean) {
  std::map<int, BlockSum> blocks;
  const double one = 1.0;
  for (int b = 0; b < kBlocks; ++b)
    for (int k = 0; k < kPoints; ++k) blocks.try_emplace(b, 1).first->second.add(&one, shared_error(b));
  const Eigen::MatrixXd independent =
      Eigen::MatrixXd::Constant(1, 1, kVarianceOfMean / kPoints);  // each point for itself
  EXPECT_NEAR(block_covariance(blocks, independent)(0, 0), kVarianceOfMean, 1e-14 * kVarianceOfMean);
}

// Two constants, of every other point each, whose blocks err by (e, -2 e): variances, covariance and sign.
TEST(BlockCovariance, OfTwoParametersHasTheirCorrelation) {
  std::map<int, BlockSum> blocks;
  const double first[] = {1.0, 0.0}, second[] = {0.0, 1.0};
  for (int b = 0; b < kBlocks; ++b) {
    BlockSum& sum = blocks.try_emplace(b, 2).first->second;
    for (int k = 0; k < kPoints; ++k) {
      sum.add(first, shared_error(b));
      sum.add(second, -2.0 * shared_error(b));
    }
  }
  const Eigen::MatrixXd c = block_covariance(blocks, 1e-3 * Eigen::MatrixXd::Identity(2, 2));
  EXPECT_NEAR(c(0, 0), kVarianceOfMean, 1e-14 * kVarianceOfMean);
  EXPECT_NEAR(c(1, 1), 4.0 * kVarianceOfMean, 4e-14 * kVarianceOfMean);
  EXPECT_NEAR(c(0, 1), -2.0 * kVarianceOfMean, 2e-14 * kVarianceOfMean);
  EXPECT_EQ(c(0, 1), c(1, 0));
}

TEST(BlockCovariance, NoVarianceFallsBelowThatOfIndependentPoints) {
  std::map<int, BlockSum> blocks;
  const double one = 1.0;
  for (int b = 0; b < kBlocks; ++b) blocks.try_emplace(b, 1).first->second.add(&one, shared_error(b));
  const Eigen::MatrixXd larger = Eigen::MatrixXd::Constant(1, 1, 3.0 * kVarianceOfMean);
  EXPECT_NEAR(block_covariance(blocks, larger)(0, 0), larger(0, 0), 1e-14 * larger(0, 0));
}

TEST(BlockCovariance, TooFewBlocksChangeNothing) {
  std::map<int, BlockSum> blocks;
  const double one = 1.0;
  for (int b = 0; b + 1 < static_cast<int>(kFewestBlocks); ++b)
    blocks.try_emplace(b, 1).first->second.add(&one, 100.0 * shared_error(b));
  const Eigen::MatrixXd independent = Eigen::MatrixXd::Constant(1, 1, 0.25);
  EXPECT_EQ(block_covariance(blocks, independent), independent);
}

TEST(BlockCovariance, BlocksAreSquaresOfTheImage) {
  std::vector<Eigen::Vector2f> q;
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 160; ++x) q.emplace_back(static_cast<float>(x), static_cast<float>(y));
  std::map<int, int> size;
  for (const int block : image_blocks(q)) ++size[block];
  EXPECT_EQ(size.size(), 25u);  // 5 x 5 of 32 px
  for (const auto& [block, n] : size) EXPECT_EQ(n, 32 * 32);
}

}  // namespace
}  // namespace fringetwin::measure::block_covariance_test
