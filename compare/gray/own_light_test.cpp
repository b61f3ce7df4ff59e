// SPDX-License-Identifier: Apache-2.0
// The line of a pixel's values over the light that is predicted for it, and what noise leaves in it.
//
// | check                     | tolerance | origin |
// |---------------------------|-----------|-------------------------------------------------------------------|
// | line through exact values | 1e-12     | rounding of sums of 8 products of 100 | | variance against draws
// | 5 %       | 20,000 draws: 1 % standard error of a variance, 4 sigma and a bit |
#include "compare/gray/own_light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace fringetwin::compare::own_light_test {
namespace {

const std::vector<double> kLight{10.0, 25.0, 31.0, 44.0, 58.0, 66.0, 71.0, 90.0};

OwnLightSums exact(double factor, double offset_dn, double gain_dn = 1.0) {
  OwnLightSums sums;
  for (const double x : kLight) sums.add(x, factor * gain_dn * x + offset_dn);
  return sums;
}

TEST(OwnLight, IsWhatWasPutIn) {
  constexpr double kGain = 3.5;
  const OwnLight both = exact(0.7, 12.0, kGain).line({.factor = true, .offset = true}, kGain);
  EXPECT_NEAR(both.factor, 0.7, 1e-12);
  EXPECT_NEAR(both.offset_dn, 12.0, 1e-12);
  const OwnLight factor = exact(0.7, 0.0, kGain).line({.factor = true}, kGain);
  EXPECT_NEAR(factor.factor, 0.7, 1e-12);
  EXPECT_EQ(factor.offset_dn, 0.0);
  const OwnLight offset = exact(1.0, -4.0, kGain).line({.offset = true}, kGain);
  EXPECT_EQ(offset.factor, 1.0);
  EXPECT_NEAR(offset.offset_dn, -4.0, 1e-12);
  const OwnLight none = exact(0.7, 12.0).line({});
  EXPECT_EQ(none.factor, 1.0);
  EXPECT_EQ(none.offset_dn, 0.0);
}

TEST(OwnLight, HasNoFactorThatTheValuesDoNotTell) {
  EXPECT_EQ(exact(-0.5, 90.0).line({.factor = true, .offset = true}).factor, 0.0);  // no light is negative
  OwnLightSums even;
  for (const double y : {14.0, 16.0, 15.0}) even.add(10.0, y);
  const OwnLight own = even.line({.factor = true, .offset = true});
  EXPECT_EQ(own.factor, 1.0);
  EXPECT_NEAR(own.offset_dn, 5.0, 1e-12);
  const OwnLight dark = OwnLightSums().line({.factor = true, .offset = true});
  EXPECT_EQ(dark.factor, 1.0);
  EXPECT_EQ(dark.offset_dn, 0.0);
}

// Noise that grows with the level, as shot noise does.
TEST(OwnLight, HasTheVarianceOfItsValues) {
  constexpr int kDraws = 20'000;
  constexpr double kAt = 80.0;
  const auto variance_of = [](double light) { return 0.4 + light / 30.0; };
  for (const OwnKinds& kinds :
       {OwnKinds{.factor = true}, OwnKinds{.offset = true}, OwnKinds{.factor = true, .offset = true}}) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal(0.0, 1.0);
    double sum2 = 0.0, stated = 0.0;
    for (int draw = 0; draw < kDraws; ++draw) {
      OwnLightSums sums;
      for (const double x : kLight)
        sums.add(x, x + std::sqrt(variance_of(x)) * normal(random), variance_of(x));
      const OwnLight own = sums.line(kinds);
      sum2 += std::pow(own.factor * kAt + own.offset_dn - kAt, 2);
      stated = sums.variance_at(kinds, kAt);
    }
    EXPECT_NEAR(sum2 / kDraws / stated, 1.0, 0.05) << kinds.factor << kinds.offset;
  }
  EXPECT_EQ(exact(1.0, 0.0).variance_at({}, kAt), 0.0);
}

}  // namespace
}  // namespace fringetwin::compare::own_light_test
