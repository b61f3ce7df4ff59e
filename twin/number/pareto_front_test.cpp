// SPDX-License-Identifier: Apache-2.0
// No tolerances: sets of indices.
#include "twin/number/pareto_front.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace fringetwin::pareto_front_test {
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

}  // namespace
}  // namespace fringetwin::pareto_front_test
