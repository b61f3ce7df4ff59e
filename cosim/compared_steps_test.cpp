// SPDX-License-Identifier: Apache-2.0
// No tolerances: numbers of steps.
#include "cosim/compared_steps.hpp"

#include <gtest/gtest.h>

#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cosim::compared_steps_test {
namespace {

using Steps = std::vector<int>;

Twin of_steps(int n) {
  Twin twin = testing::paper_rig();
  twin.fringes.steps = n;
  return twin;
}

TEST(ComparedSteps, AreEverySecondOfThoseThatMayBe) {
  EXPECT_EQ(compared_steps(of_steps(7), "even", {}), (Steps{0, 2, 4, 6}));
  EXPECT_EQ(compared_steps(of_steps(7), "odd", {}), (Steps{1, 3, 5}));
  EXPECT_EQ(compared_steps(of_steps(12), "odd", {1, 2, 5, 7, 8}), (Steps{1, 5, 7}));
}

TEST(ComparedSteps, FewerThanThreeAreRefused) {
  EXPECT_THROW(compared_steps(of_steps(5), "odd", {}), UserError);
  EXPECT_THROW(compared_steps(of_steps(12), "even", {0, 1, 2, 3, 5, 7}), UserError);
}

}  // namespace
}  // namespace fringetwin::cosim::compared_steps_test
