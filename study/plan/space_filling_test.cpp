// SPDX-License-Identifier: Apache-2.0
#include "study/plan/space_filling.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <set>

#include "render/base/sobol.hpp"

namespace fringetwin::testing::space_filling_test {
namespace {
using namespace fringetwin::study;

UnitPoints latin_hypercube(int n, int dimensions, std::uint64_t seed) {
  const LatinHypercube hypercube(n, dimensions, seed);
  UnitPoints points;
  for (int i = 0; i < n; ++i) points.push_back(hypercube.point(static_cast<std::size_t>(i)));
  return points;
}

/// Every coordinate in [0, 1), and one of n points in each of n equal intervals of each dimension.
void expect_stratified(const UnitPoints& points) {
  const auto n = static_cast<double>(points.size());
  for (std::size_t d = 0; d < points.front().size(); ++d) {
    std::set<int> intervals;
    for (const auto& point : points) {
      ASSERT_GE(point[d], 0.0);
      ASSERT_LT(point[d], 1.0);
      intervals.insert(static_cast<int>(std::floor(point[d] * n)));
    }
    EXPECT_EQ(intervals.size(), points.size()) << "dimension " << d;
  }
}

/// Squared L2 star discrepancy (Warnock 1972).
double star_discrepancy2(const UnitPoints& points) {
  const auto n = static_cast<double>(points.size());
  const auto dimensions = points.front().size();
  double sum1 = 0.0, sum2 = 0.0;
  for (const auto& x : points) {
    double product = 1.0;
    for (const double value : x) product *= 0.5 * (1.0 - value * value);
    sum1 += product;
    for (const auto& y : points) {
      double pair = 1.0;
      for (std::size_t d = 0; d < dimensions; ++d) pair *= 1.0 - std::max(x[d], y[d]);
      sum2 += pair;
    }
  }
  return std::pow(1.0 / 3.0, static_cast<double>(dimensions)) - 2.0 * sum1 / n + sum2 / (n * n);
}
/// Its mean over random points: (2^-d - 3^-d) / n.
double random_discrepancy2(std::size_t n, int dimensions) {
  return (std::pow(0.5, dimensions) - std::pow(1.0 / 3.0, dimensions)) / static_cast<double>(n);
}

TEST(SpaceFilling, LatinHypercubeIsStratified) {
  for (const int n : {1, 2, 7, 100, 1000}) expect_stratified(latin_hypercube(n, 5, 3));
}

TEST(SpaceFilling, SobolIsANetAfterScrambling) {
  for (const std::uint64_t seed : {0U, 1U, 99U})
    expect_stratified(scrambled_sobol(256, render::kSobolDimensions, seed));
  // the first two dimensions: one of 2^k points in each elementary 2^a x 2^b rectangle
  const UnitPoints points = scrambled_sobol(64, 2, 5);
  for (int a = 0; a <= 6; ++a) {
    std::set<std::pair<int, int>> cells;
    for (const auto& p : points)
      cells.emplace(static_cast<int>(std::ldexp(p[0], a)), static_cast<int>(std::ldexp(p[1], 6 - a)));
    EXPECT_EQ(cells.size(), 64u);
  }
}

// Owen's scrambling, told from a digital shift: two coordinates part at the same bit as before, and below it
// the bits of the two are turned independently, half of them differently. A shift turns all alike. 5 sigma of
// as many coins as there are bits below.
TEST(SpaceFilling, ScramblingIsNestedAndNoShift) {
  constexpr std::uint32_t n = 64;
  const UnitPoints points = scrambled_sobol(n, 8, 11);
  int apart = 0, below = 0;
  for (const std::uint32_t d : {0U, 1U, 7U}) {
    const auto directions = render::sobol_directions(static_cast<int>(d));
    const auto bits = [&](std::uint32_t i) { return static_cast<std::uint32_t>(points[i][d] * 0x1p32); };
    for (std::uint32_t i = 0; i < n; i += 2) {
      const std::uint32_t before = render::sobol_coordinate(directions, i) ^
                                   render::sobol_coordinate(directions, i + 1),
                          after = bits(i) ^ bits(i + 1);
      EXPECT_EQ(std::countl_zero(after), std::countl_zero(before)) << "points " << i << ", dimension " << d;
      const int free = 31 - std::countl_zero(before);
      apart += std::popcount((before ^ after) & ((1U << free) - 1U));
      below += free;
    }
  }
  EXPECT_NEAR(apart, 0.5 * below, 5.0 * 0.5 * std::sqrt(below));
}

TEST(SpaceFilling, SeedsDecideAndALongerSobolGoesOn) {
  EXPECT_EQ(latin_hypercube(50, 3, 1), latin_hypercube(50, 3, 1));
  EXPECT_NE(latin_hypercube(50, 3, 1), latin_hypercube(50, 3, 2));
  // a study that is resumed by a later program goes on with the points of its study.db
  const LatinHypercube first_release(1000, 7, 5);
  EXPECT_EQ(first_release.point(0)[0], 0.47676598215779986);
  EXPECT_EQ(first_release.point(999)[6], 0.37934818181194441);
  EXPECT_NE(scrambled_sobol(50, 3, 1), scrambled_sobol(50, 3, 2));
  const UnitPoints shorter = scrambled_sobol(50, 3, 1);
  UnitPoints longer = scrambled_sobol(80, 3, 1);
  longer.resize(50);
  EXPECT_EQ(shorter, longer);
}

// Each point alone is uniform over the seeds: mean 1/2 and variance 1/12 within 5 standard errors of 2000
// draws (1 / sqrt(12 n) and sqrt(1/180 / n)).
TEST(SpaceFilling, EveryPointIsUniformOverTheSeeds) {
  constexpr int n = 2000;
  for (const bool sobol : {false, true}) {
    double sum = 0.0, sum2 = 0.0;
    for (int seed = 0; seed < n; ++seed) {
      const auto s = static_cast<std::uint64_t>(seed);
      const double x = (sobol ? scrambled_sobol(4, 2, s) : latin_hypercube(4, 2, s))[0][1];
      sum += x - 0.5;
      sum2 += (x - 0.5) * (x - 0.5);
    }
    EXPECT_NEAR(sum / n, 0.0, 5.0 / std::sqrt(12.0 * n)) << sobol;
    EXPECT_NEAR(sum2 / n, 1.0 / 12.0, 5.0 * std::sqrt(1.0 / 180.0 / n)) << sobol;
  }
}

// Of 512 points in 5 dimensions, mean over 8 seeds: a Latin hypercube lies below random points, Sobol's lie
// below a fifth of them (random points scatter by less than a third about their mean).
TEST(SpaceFilling, DiscrepancyIsBelowThatOfRandomPoints) {
  double latin = 0.0, sobol = 0.0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    latin += star_discrepancy2(latin_hypercube(512, 5, seed)) / 8.0;
    sobol += star_discrepancy2(scrambled_sobol(512, 5, seed)) / 8.0;
  }
  const double random = random_discrepancy2(512, 5);
  EXPECT_LT(latin, 0.67 * random);
  EXPECT_LT(sobol, 0.2 * random);
  EXPECT_GT(sobol, 0.0);
}

}  // namespace
}  // namespace fringetwin::testing::space_filling_test
