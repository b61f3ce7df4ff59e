// SPDX-License-Identifier: Apache-2.0
// No tolerances: sets of indices.
#include "twin/base/pareto_front.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tradeoff/pareto.hpp"

namespace fringetwin::study::front_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ParetoFront, ByHand) {
  EXPECT_THAT(pareto_front({}), IsEmpty());
  EXPECT_THAT(pareto_front({{3, 1}, {1, 5}, {2, 5}, {2, 3}, {4, 2}}), ElementsAre(1, 3, 0));
  EXPECT_THAT(pareto_front({{1, 1}, {1, 1}}), ElementsAre(0)) << "equal points: the first";
  EXPECT_THAT(pareto_front({{1, 2}, {1, 1}}), ElementsAre(1)) << "equal cost: the better";
  EXPECT_THAT(pareto_front({{2, 1}, {1, 1}}), ElementsAre(1)) << "equal error: the cheaper";
}

TEST(ParetoFront, UnknownValuesTakeNoPart) {
  const double nan = std::nan("");
  EXPECT_THAT(pareto_front({{nan, 0}, {1, nan}, {5, 5}}), ElementsAre(2));
  EXPECT_THAT(pareto_front({{nan, nan}}), IsEmpty());
}

// Against the definition, point by point.
TEST(ParetoFront, AgreesWithTheDefinition) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<CostAndError> points(1 + random() % 12);
    for (auto& p : points) p = {static_cast<double>(random() % 5), static_cast<double>(random() % 5)};
    const auto front = pareto_front(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      bool beaten = false;
      for (std::size_t j = 0; j < points.size(); ++j) {
        const bool no_worse = points[j].cost <= points[i].cost && points[j].error <= points[i].error;
        const bool equal = points[j].cost == points[i].cost && points[j].error == points[i].error;
        beaten = beaten || (no_worse && (!equal || j < i));
      }
      EXPECT_EQ(std::find(front.begin(), front.end(), i) == front.end(), beaten) << "point " << i;
    }
  }
}

TEST(ParetoFront, MarksEachPairOfQuantitiesByItself) {
  std::vector<ParetoPoint> points(3);
  const auto fill = [](ParetoPoint& p, double ms, double rad, double dn, double s, double mm) {
    p.frame_ms = ms;
    p.error.phase_interior_rms_rad = rad;
    p.error.gray_rms_dn = dn;
    p.chain_s = s;
    p.fit_shift_mm = mm;
  };
  fill(points[0], 1, 3, 1, 1, std::nan(""));
  fill(points[1], 2, 2, 2, 3, 1e-3);
  fill(points[2], 3, 1, 3, 2, 1e-3);
  mark_fronts(points);
  EXPECT_TRUE(points[0].on_phase_front && points[1].on_phase_front && points[2].on_phase_front);
  EXPECT_TRUE(points[0].on_gray_front && !points[1].on_gray_front && !points[2].on_gray_front);
  EXPECT_TRUE(!points[0].on_fit_front && !points[1].on_fit_front && points[2].on_fit_front);
  points[2].is_fit_reference = true;
  points[2].on_fit_front = false;
  mark_fronts(points);
  EXPECT_TRUE(points[1].on_fit_front && !points[2].on_fit_front) << "a shift against itself is no error of 0";
}

// The published scheme is there, the default is marked exactly once, whatever it is.
TEST(SchemeTable, HoldsTheDefaultAndThePublishedScheme) {
  Twin twin;
  for (const auto samples : {std::optional<int>{}, std::optional<int>{25}, std::optional<int>{1000}}) {
    twin.render.samples = samples;
    for (const bool quick : {false, true}) {
      int n_default = 0, n_published = 0;
      for (const Scheme& s : scheme_table(twin, true, quick)) {
        n_default += s.is_default;
        n_published += s.is_published;
      }
      EXPECT_EQ(n_default, 1);
      EXPECT_EQ(n_published, quick ? 0 : 1);
    }
  }
}

}  // namespace
}  // namespace fringetwin::study::front_test
