// SPDX-License-Identifier: Apache-2.0
#include "study/design/design.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "render/base/sobol.hpp"

namespace fringetwin::testing::design_test {
namespace {
using namespace fringetwin::study;
using ::testing::ElementsAre;

Variation values(std::vector<std::string> keys, std::vector<std::string> texts) {
  return {std::move(keys), std::move(texts), {}, std::nullopt};
}
Variation range(const std::string& key, double first, double last, std::optional<int> count,
                bool log = false) {
  return {{key}, {}, {}, Range{first, last, count, log}};
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

TEST(Design, LatinHypercubeIsStratified) {
  for (const int n : {1, 2, 7, 100, 1000}) expect_stratified(latin_hypercube(n, 5, 3));
}

TEST(Design, SobolIsANetAfterScrambling) {
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

TEST(Design, SeedsDecideAndALongerSobolGoesOn) {
  EXPECT_EQ(latin_hypercube(50, 3, 1), latin_hypercube(50, 3, 1));
  EXPECT_NE(latin_hypercube(50, 3, 1), latin_hypercube(50, 3, 2));
  EXPECT_NE(scrambled_sobol(50, 3, 1), scrambled_sobol(50, 3, 2));
  const UnitPoints shorter = scrambled_sobol(50, 3, 1);
  UnitPoints longer = scrambled_sobol(80, 3, 1);
  longer.resize(50);
  EXPECT_EQ(shorter, longer);
}

// Each point alone is uniform over the seeds: mean 1/2 and variance 1/12 within 5 standard errors of 2000
// draws (1 / sqrt(12 n) and sqrt(1/180 / n)).
TEST(Design, EveryPointIsUniformOverTheSeeds) {
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
TEST(Design, DiscrepancyIsBelowThatOfRandomPoints) {
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

TEST(Design, RangesReachBothEnds) {
  EXPECT_THAT(listed_values(range("a", 8, 40, 5)), ElementsAre("8", "16", "24", "32", "40"));
  EXPECT_THAT(listed_values(range("a", 0.1, 0.3, 3)), ElementsAre("0.1", "0.2", "0.3"));
  EXPECT_THAT(listed_values(range("a", 1, 1000, 4, true)), ElementsAre("1", "10", "100", "1000"));
  for (int last = 1; last < 200; ++last)
    EXPECT_EQ(listed_values(range("a", 0, last, last + 1))[static_cast<std::size_t>(last * 2 / 3)],
              std::to_string(last * 2 / 3));
  EXPECT_EQ(value_at(range("a", 1, 100, std::nullopt, true), 0.5), "10");
  EXPECT_EQ(value_at(range("a", -1, 3, std::nullopt), 0.375), "0.5");
  const Variation depths = values({"d"}, {"8", "10", "12"});
  EXPECT_EQ(value_at(depths, 0.0), "8");
  EXPECT_EQ(value_at(depths, 0.34), "10");
  EXPECT_EQ(value_at(depths, 0.9999999999999999), "12");
}

TEST(Design, GridCountsTheLastFastestAndSeedsFaster) {
  StudyFile study;
  study.vary = {values({"a", "b"}, {"1", "2"}), range("c", 0, 1, 2)};
  study.noise_seeds = 2;
  study.first_noise_seed = 7;
  const auto points = design_points(study);
  ASSERT_EQ(points.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(points[i].id, static_cast<std::int64_t>(i));
    EXPECT_EQ(points[i].seed, 7 + i % 2);
    const std::string first = i < 4 ? "1" : "2";
    EXPECT_EQ(points[i].settings, (Settings{{"a", first}, {"b", first}, {"c", i / 2 % 2 == 0 ? "0" : "1"}}));
  }
}

TEST(Design, ListTakesValuesSideBySide) {
  StudyFile study;
  study.design = Design::list;
  study.vary = {values({"a"}, {"1", "2", "3"}), values({"b"}, {"\"x\"", "\"y\"", "\"z\""})};
  const auto points = design_points(study);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[2].settings, (Settings{{"a", "3"}, {"b", "\"z\""}}));
  study.vary.clear();
  study.noise_seeds = 5;
  EXPECT_EQ(design_points(study).size(), 5u) << "the twin itself, repeated";
}

TEST(Design, ARowGivesEachKeyItsOwnValue) {
  Variation depth = values({"bits", "gain"}, {"8", "10"});
  depth.rows = {{"8", "22"}, {"10", "88"}};
  StudyFile study;
  study.vary = {depth, values({"noise"}, {"1"})};
  const Settings second{{"bits", "10"}, {"gain", "88"}, {"noise", "1"}};
  EXPECT_EQ(design_points(study).at(1).settings, second);
  study.design = Design::list;
  study.vary.pop_back();
  EXPECT_EQ(design_points(study).at(1).settings, (Settings{{"bits", "10"}, {"gain", "88"}}));
  study.design = Design::latin_hypercube;
  study.points = 2;
  const auto points = design_points(study);
  EXPECT_NE(points[0].settings, points[1].settings);
  for (const StudyPoint& p : points)
    EXPECT_EQ(p.settings.at("gain"), p.settings.at("bits") == "8" ? "22" : "88");
}

TEST(Design, SampledDesignsSpreadOverRangesAndLists) {
  for (const Design design : {Design::latin_hypercube, Design::sobol}) {
    StudyFile study;
    study.design = design;
    study.points = 64;
    study.vary = {range("a", 10, 20, std::nullopt), values({"b", "c"}, {"8", "10", "12", "16"})};
    const auto points = design_points(study);
    ASSERT_EQ(points.size(), 64u);
    std::map<std::string, int> depths;
    double sum = 0.0;
    for (const StudyPoint& point : points) {
      const double a = std::stod(point.settings.at("a"));
      EXPECT_GE(a, 10.0);
      EXPECT_LE(a, 20.0);
      sum += a;
      ++depths[point.settings.at("b")];
      EXPECT_EQ(point.settings.at("b"), point.settings.at("c"));
    }
    EXPECT_NEAR(sum / 64, 15.0, 0.5 * 10.0 / 64) << "each interval's point lies within half its width";
    for (const auto& [depth, n] : depths) EXPECT_EQ(n, 16) << depth;
  }
}

}  // namespace
}  // namespace fringetwin::testing::design_test
