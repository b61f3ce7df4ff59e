// SPDX-License-Identifier: Apache-2.0
// No tolerances: what is left off, and sums of small integers.
#include "tradeoff/recommend.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fringetwin::tradeoff::recommend_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
const double nan = std::nan("");
constexpr double inf = std::numeric_limits<double>::infinity();

TEST(Recommendation, DearestFirst) {
  const Tolerance t{10, 10, 10};
  EXPECT_THAT(leave_off({{{1, 1, 1}, 1.0}, {{1, 1, 1}, 5.0}, {{1, 1, 1}, 2.0}}, t), ElementsAre(1, 2, 0));
}

TEST(Recommendation, ChangesAddUpInEveryQuantity) {
  const Tolerance t{10, 1, 1};
  // 6 + 5 rad is too much, though each is not; the third fits beside the first
  EXPECT_THAT(leave_off({{{6, 0, 0}, 3.0}, {{5, 0, 0}, 2.0}, {{4, 0, 0}, 1.0}}, t), ElementsAre(0, 2));
  EXPECT_THAT(leave_off({{{0, 2, 0}, 9.0}}, t), IsEmpty());
  EXPECT_THAT(leave_off({{{0, 0, 2}, 9.0}}, t), IsEmpty());
}

TEST(Recommendation, EqualCostSmallestChangeFirst) {
  EXPECT_THAT(leave_off({{{6, 0, 0}, 1.0}, {{5, 0, 0}, 1.0}}, {10, 1, 1}), ElementsAre(1));
}

TEST(Recommendation, UnknownIsNotJudgedAndLostIsTooMuch) {
  const Tolerance t{1, 1, 1};
  EXPECT_THAT(leave_off({{{nan, 0.5, nan}, 1.0}}, t), ElementsAre(0));
  EXPECT_THAT(leave_off({{{inf, 0.5, nan}, 1.0}}, t), IsEmpty());
  const Change sum = Change{nan, 1, nan} + Change{nan, 2, 3};
  EXPECT_TRUE(std::isnan(sum.phase_rad));
  EXPECT_EQ(sum.gray_dn, 3);
  EXPECT_EQ(sum.fit_mm, 3);
}

TEST(Recommendation, ToleranceZeroKeepsWhatChangesAnything) {
  EXPECT_THAT(leave_off({{{0, 0, 0}, 1.0}, {{1e-12, 0, 0}, 9.0}}, {0, 0, 0}), ElementsAre(0));
}

}  // namespace
}  // namespace fringetwin::tradeoff::recommend_test
