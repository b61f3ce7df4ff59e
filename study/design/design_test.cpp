// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "study/design/design_plan.hpp"
#include "study/plan/space_filling.hpp"
#include "study/plan/study_tables.hpp"

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
  DesignPlan plan;
  plan.vary = {values({"a", "b"}, {"1", "2"}), range("c", 0, 1, 2)};
  plan.noise_seeds = 2;
  plan.first_noise_seed = 7;
  const auto points = design_points(plan);
  ASSERT_EQ(points.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(points[i].id, static_cast<std::int64_t>(i));
    EXPECT_EQ(points[i].seed, 7 + i % 2);
    const std::string first = i < 4 ? "1" : "2";
    EXPECT_EQ(points[i].settings, (Settings{{"a", first}, {"b", first}, {"c", i / 2 % 2 == 0 ? "0" : "1"}}));
  }
}

TEST(Design, ListTakesValuesSideBySide) {
  DesignPlan plan;
  plan.design = Design::list;
  plan.vary = {values({"a"}, {"1", "2", "3"}), values({"b"}, {"\"x\"", "\"y\"", "\"z\""})};
  const auto points = design_points(plan);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[2].settings, (Settings{{"a", "3"}, {"b", "\"z\""}}));
  plan.vary.clear();
  plan.noise_seeds = 5;
  EXPECT_EQ(design_points(plan).size(), 5u) << "the twin itself, repeated";
}

TEST(Design, ARowGivesEachKeyItsOwnValue) {
  Variation depth = values({"bits", "gain"}, {"8", "10"});
  depth.rows = {{"8", "22"}, {"10", "88"}};
  DesignPlan plan;
  plan.vary = {depth, values({"noise"}, {"1"})};
  const Settings second{{"bits", "10"}, {"gain", "88"}, {"noise", "1"}};
  EXPECT_EQ(design_points(plan)[1].settings, second);
  plan.design = Design::list;
  plan.vary.pop_back();
  EXPECT_EQ(design_points(plan)[1].settings, (Settings{{"bits", "10"}, {"gain", "88"}}));
  plan.design = Design::latin_hypercube;
  plan.points = 2;
  const auto points = design_points(plan);
  EXPECT_NE(points[0].settings, points[1].settings);
  for (const StudyPoint& p : points)
    EXPECT_EQ(p.settings.at("gain"), p.settings.at("bits") == "8" ? "22" : "88");
}

TEST(Design, PointsOfTheLargestAreMadeWhenAskedFor) {
  DesignPlan plan;
  for (int i = 0; i < 6; ++i) plan.vary.push_back(range("key" + std::to_string(i), 0, 9, 10));
  const auto grid = design_points(plan);
  ASSERT_EQ(grid.size(), 1'000'000u);
  EXPECT_EQ(
      grid[987'654].settings,
      (Settings{{"key0", "9"}, {"key1", "8"}, {"key2", "7"}, {"key3", "6"}, {"key4", "5"}, {"key5", "4"}}));
  plan.noise_seeds = 1'000'000;
  plan.vary.resize(1);
  plan.vary[0] = values({"a"}, {"1"});
  const StudyPoint last = design_points(plan)[999'999];
  EXPECT_EQ(last.id, 999'999);
  EXPECT_EQ(last.seed, 1'000'000u);
  plan.noise_seeds = 3;
  plan.design = Design::sobol;
  plan.points = 300'000;
  plan.vary = {range("a", 0, 1, std::nullopt), range("b", 0, 1, std::nullopt)};
  const auto sobol = design_points(plan);
  const double place = scrambled_sobol(300'000, 2, plan.seed)[299'999][1];
  EXPECT_EQ(sobol[899'999].settings.at("b"), value_at(plan.vary[1], place));
}

TEST(Design, SampledDesignsSpreadOverRangesAndLists) {
  for (const Design design : {Design::latin_hypercube, Design::sobol}) {
    DesignPlan plan;
    plan.design = design;
    plan.points = 64;
    plan.vary = {range("a", 10, 20, std::nullopt), values({"b", "c"}, {"8", "10", "12", "16"})};
    const auto points = design_points(plan);
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
