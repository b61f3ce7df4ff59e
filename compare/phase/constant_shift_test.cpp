// SPDX-License-Identifier: Apache-2.0
// A shift planted on all decoded coordinates is found exactly; one that varies over the image, as a displaced
// surface makes it, or one of a tenth of a period is none.
#include "compare/phase/constant_shift.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::constant_shift_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::SyntheticSides;

constexpr double kPitch_px = 13.0;  ///< the finest one of make_sides()

/// Two alike sides whose real coordinates are then moved by shift_px, and by slope of it more from the left
/// to the right of the image.
SyntheticSides moved(double shift_px, double slope = 0.0) {
  SyntheticSides s = testing::make_sides({});
  ImageD& x_px = s.real.measurement->cameras[0].directions[0].coordinate_px;
  for (int y = 0; y < x_px.height; ++y)
    for (int x = 0; x < x_px.width; ++x) x_px(x, y) += shift_px * (1.0 + slope * x / x_px.width);
  return s;
}

std::optional<double> shift_of(const SyntheticSides& s) {
  return constant_shift_px(s.real.measurement->cameras[0].directions[0],
                           s.simulated.measurement->cameras[0].directions[0]);
}

TEST(ConstantShift, IsFoundWithItsSign) {
  for (const double shift_px : {-0.5 * kPitch_px, 0.25 * kPitch_px, 8.0}) {
    const auto found = shift_of(moved(shift_px));
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(*found, shift_px, 0.002);  // 5 times the noise of a pixel, 0.03 px, over the root of 6,000
  }
}

TEST(ConstantShift, IsNoneWhereItIsSmallOrVaries) {
  EXPECT_FALSE(shift_of(moved(0.0)).has_value());
  EXPECT_FALSE(shift_of(moved(0.1 * kPitch_px)).has_value());
  EXPECT_FALSE(shift_of(moved(0.5 * kPitch_px, 0.5)).has_value());  // 25 % of a pitch across the image
}

TEST(ConstantShift, IsAWarningThatNamesTheOriginAndThePhaseIsNotExplained) {
  SyntheticSides s = moved(-8.0);  // beyond half a period: no fringe order is the twin's
  const Comparison c = compare(s.twin, s.real, s.simulated, {});
  EXPECT_THAT(c.warnings, Contains(HasSubstr("phase_origin_px = 8 in place of 0")));
  EXPECT_EQ(c.budget_verdict().phase, kNotExplained);
  EXPECT_THAT(compare(moved(0.0).twin, moved(0.0).real, moved(0.0).simulated, {}).warnings,
              Not(Contains(HasSubstr("phase_origin_px"))));
}

TEST(ConstantShift, OrdersThatDisagreeAreNotExplained) {
  SyntheticSides s = moved(0.0);
  ImageD& x_px = s.real.measurement->cameras[0].directions[0].coordinate_px;
  for (int y = 0; y < x_px.height; ++y)
    for (int x = 0; x < 100; ++x) x_px(x, y) += kPitch_px;  // 100 of 192 columns are off by a period
  const Comparison c = compare(s.twin, s.real, s.simulated, {});
  EXPECT_EQ(c.budget_verdict().phase, kNotExplained);
  EXPECT_THAT(c.warnings, Contains(HasSubstr("fringe orders disagree")));
}

}  // namespace
}  // namespace fringetwin::compare::constant_shift_test
