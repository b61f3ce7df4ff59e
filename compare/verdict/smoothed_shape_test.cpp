// SPDX-License-Identifier: Apache-2.0
// Regions whose sums are drawn: noise, and what smoothing or another error adds to them.
#include "compare/verdict/smoothed_shape.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "compare/verdict/block_sums.hpp"

namespace fringetwin::compare::smoothed_shape_test {
namespace {

constexpr double kShare = 0.02;  ///< of squares over 20,000 sums: 4.5 sqrt(0.2/20,000) is 0.014

/// Returns the share that is called smoothed of regions which differ by `of_smoothed` times what smoothing
/// has added to them, `of_else` times something else, and noise; both have a variance of 9 times that of
/// noise.
double fraction(double of_smoothed, double of_else) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  Sums sums;
  for (int region = 0; region < 20'000; ++region) {
    BlockSum block{.variance = 2.0};
    block.pixels = kFewestInRegion;
    const double slopes = 3.0 * std::sqrt(2.0) * normal(random),
                 other = 3.0 * std::sqrt(2.0) * normal(random);
    block.smoothed_slopes = slopes;
    block.sum = of_smoothed * slopes + of_else * other + std::sqrt(2.0) * normal(random);
    add_region(block, 0.0, sums);
  }
  return smoothed_fraction(sums);
}

TEST(SmoothedShape, TheShareIsThatWhichGoesWithSmoothing) {
  EXPECT_NEAR(fraction(1.0, 0.0), 0.9, kShare);
  EXPECT_NEAR(fraction(1.0, 1.0), 9.0 / 19.0, kShare);
  EXPECT_NEAR(fraction(0.0, 1.0), 0.0, kShare);
  EXPECT_EQ(fraction(-1.0, 0.0), 0.0) << "as the noise of the shape goes";
}

TEST(SmoothedShape, AFewRegionsTellNothing) {
  Sums sums;
  for (int region = 0; region < 29; ++region) {
    BlockSum block{.variance = 1.0};
    block.pixels = kFewestInRegion;
    block.sum = block.smoothed_slopes = region;
    add_region(block, 0.0, sums);
  }
  EXPECT_EQ(smoothed_fraction(sums), 0.0);
}

TEST(SmoothedShape, WhatSmoothingAddsIsAllowedForOnce) {
  BlockSum block{.variance = 4.0};
  block.slopes = 2.0, block.smoothed_slopes = -3.0, block.depths = 1.0, block.smoothed_depths = 0.5;
  EXPECT_DOUBLE_EQ(block.expected(0.0), 4.0 + 9.0 + 1.0) << "of both only the larger one";
}

/// A row on gray values whose regions fail by so much.
ExplainedRow gray_row(double smoothed_fraction) {
  ExplainedRow row;
  row.quantity = "gray";
  row.region = "left";
  row.state = kNotExplained;
  row.regional_chi2 = 5.0, row.regional_limit = 1.1;
  row.smoothed_fraction = smoothed_fraction;
  return row;
}

TEST(SmoothedShape, SmallerWindowsComeBeforeCausesWhereTheyCanBeHad) {
  ShapeNoise noise;
  std::vector<std::string> warnings;
  for (const double radius_px : {4.0, 2.0}) {
    noise.surface.radius_px = radius_px;
    std::vector<ExplainedRow> rows{gray_row(0.8)};
    EXPECT_EQ(doubt_smoothing(&noise, rows, warnings), radius_px > 3.0);
    EXPECT_NE(rows[0].why.find("80 % of what regions differ by beside noise"), std::string::npos)
        << rows[0].why;
    EXPECT_EQ(rows[0].why.find("smoothing_px") != std::string::npos, radius_px > 3.0) << rows[0].why;
  }
  EXPECT_EQ(warnings.size(), 1U);
}

TEST(SmoothedShape, OtherRowsAreLeftAlone) {
  ShapeNoise noise;
  noise.surface.radius_px = 4.0;
  std::vector<std::string> warnings;
  std::vector<ExplainedRow> rows(4, gray_row(0.8));
  rows[0].smoothed_fraction = 0.4;
  rows[1].state = kExplained;
  rows[2].regional_chi2 = 1.0;  // single values fail
  rows[3].quantity = "phase";
  rows.push_back(gray_row(0.8));
  rows.back().regional_chi2 = 85.0;  // much more than smoothing makes
  EXPECT_FALSE(doubt_smoothing(&noise, rows, warnings));
  for (const ExplainedRow& row : rows) EXPECT_EQ(row.why, "");
  rows = {gray_row(0.8), gray_row(0.8)};
  rows[1].quantity = "phase";
  EXPECT_FALSE(doubt_smoothing(&noise, rows, warnings)) << "causes are looked for: the phase differs, too";
  EXPECT_NE(rows[0].why, "");
  rows = {gray_row(0.8)};
  EXPECT_FALSE(doubt_smoothing(nullptr, rows, warnings)) << "no shape was measured";
  EXPECT_TRUE(warnings.empty());
}

}  // namespace
}  // namespace fringetwin::compare::smoothed_shape_test
