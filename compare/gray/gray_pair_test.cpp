// SPDX-License-Identifier: Apache-2.0
// No tolerances: bounds.
#include "compare/gray/gray_pair.hpp"

#include <gtest/gtest.h>

#include "tests/support/compare/fitted_gray.hpp"

namespace fringetwin::compare::gray_pair_test {
namespace {

// 8 bit: at least 2 DN, at most a quarter of the 255 DN.
TEST(GrayPair, EachEndOfTheRangeHasItsOwnMargin) {
  const testing::SyntheticSides sides = testing::make_sides({});
  const GrayPair pair = testing::gray_pair(sides);
  const UsableRange u = usable_range(pair, 17.0, 4.0, {.low_dn = 5.0, .high_dn = 9.0});
  EXPECT_EQ(u.low_dn, 5.0);
  EXPECT_EQ(u.high_dn, 246.0);
  EXPECT_EQ(u.gain_dn, 17.0);
  EXPECT_EQ(u.black_level_dn, 4.0);
  const UsableRange narrow = usable_range(pair, 17.0, 4.0, {.low_dn = 0.5, .high_dn = 300.0});
  EXPECT_EQ(narrow.low_dn, 2.0);
  EXPECT_EQ(narrow.high_dn, 255.0 - 0.25 * 255.0);
}

}  // namespace
}  // namespace fringetwin::compare::gray_pair_test
