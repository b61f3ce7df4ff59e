// SPDX-License-Identifier: Apache-2.0
// Exact tests: repaired coordinates equal the truth (1e-9 px: one addition), everything else is untouched.
#include "measure/decode/order_repair.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/measure/synthetic_fringes.hpp"
#include "tests/support/twin/random_values.hpp"

namespace fringetwin::measure::order_repair_test {
namespace {

constexpr double kPeriod = 60.0;
const OrderRepairOptions kOptions{kPeriod, 2, 0.25, 0.55, 8, 4, 0.0, {}};

TEST(OrderRepair, ScatteredErrorsAreMendedAndCounted) {
  const ImageD truth = testing::ramp(200, 150, 0.0, 900.0, 30.0);
  ImageD x = truth;
  std::mt19937 random(5);
  std::uint64_t wrong = 0;
  for (double& v : x.data)
    if (random() % 50 == 0) {
      v += (random() & 1u) ? kPeriod : -kPeriod;
      ++wrong;
    }
  const OrderRepair r = repair_orders(x, kOptions);
  EXPECT_EQ(r.n_checked, truth.size());
  EXPECT_EQ(r.n_changed, wrong);
  EXPECT_EQ(r.n_left, 0u);
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(x.data[i], truth.data[i], 1e-9);
}

TEST(OrderRepair, StripesAlongAWrapUpToTwoPixelsWide) {
  const ImageD truth = testing::ramp(200, 100, 0.0, 1000.0);
  for (const int wide : {1, 2}) {
    ImageD x = truth;
    for (int y = 0; y < x.height; ++y)
      for (int k = 0; k < wide; ++k) x(90 + y / 10 + k, y) += kPeriod;
    const OrderRepair r = repair_orders(x, kOptions);
    EXPECT_EQ(r.n_changed, static_cast<std::uint64_t>(wide * x.height));
    for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(x.data[i], truth.data[i], 1e-9);
  }
}

TEST(OrderRepair, DepthStepsStay) {
  // Straight steps of any height, whole periods included, and a thin wire that is no whole period off.
  for (const double step : {0.4, 0.6, 1.0, 1.5, 2.0, 3.3}) {
    ImageD truth = testing::ramp(120, 80, 0.0, 500.0, 20.0);
    for (int y = 0; y < truth.height; ++y)
      for (int x = 60; x < truth.width; ++x) truth(x, y) += step * kPeriod;
    ImageD x = truth;
    EXPECT_EQ(repair_orders(x, kOptions).n_changed, 0u) << step;
    EXPECT_EQ(x.data, truth.data);
  }
  ImageD wire = testing::ramp(120, 80, 0.0, 500.0);
  for (int y = 0; y < wire.height; ++y) wire(50, y) += 1.4 * kPeriod;
  ImageD x = wire;
  EXPECT_EQ(repair_orders(x, kOptions).n_changed, 0u);
  EXPECT_EQ(x.data, wire.data);
}

TEST(OrderRepair, JumpsThatCannotBeMendedAreCounted) {
  ImageD x = testing::ramp(100, 50, 0.0, 400.0);
  for (int y = 0; y < 50; ++y)
    for (int u = 40; u < 100; ++u) x(u, y) += kPeriod;  // half the map: nobody knows which half
  const OrderRepair r = repair_orders(x, kOptions);
  EXPECT_EQ(r.n_changed, 0u);
  EXPECT_EQ(r.n_left, 50u);
}

// Nothing is mended here: all neighbours count, those at the borders, too.
TEST(OrderRepair, JumpsAtTheBordersAreCounted) {
  OrderRepairOptions count_only = kOptions;
  count_only.max_passes = 0;
  const ImageD truth = testing::ramp(100, 50, 0.0, 400.0);
  for (const int row : {0, 49}) {
    ImageD x = truth;
    for (int u = 0; u < 100; ++u) x(u, row) += kPeriod;
    EXPECT_EQ(repair_orders(x, count_only).n_left, 100u) << "row " << row;
  }
  for (const int column : {0, 99}) {
    ImageD x = truth;
    for (int y = 0; y < 50; ++y) x(column, y) += kPeriod;
    EXPECT_EQ(repair_orders(x, count_only).n_left, 50u) << "column " << column;
  }
}

TEST(OrderRepair, HolesAndBordersAreNoNeighbours) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ImageD x = testing::ramp(60, 60, 0.0, 200.0);
  for (int y = 20; y < 40; ++y)
    for (int u = 20; u < 40; ++u) x(u, y) = nan;
  const double corner = x(0, 0), beside_hole = x(19, 30), lonely = x(30, 30);
  EXPECT_TRUE(std::isnan(lonely));
  x(0, 0) += kPeriod;
  x(19, 30) -= kPeriod;
  x(30, 30) = 5000.0;  // valid pixel in a hole: nothing to compare it with
  const OrderRepair r = repair_orders(x, kOptions);
  EXPECT_EQ(r.n_changed, 2u);
  EXPECT_NEAR(x(0, 0), corner, 1e-9);
  EXPECT_NEAR(x(19, 30), beside_hole, 1e-9);
  EXPECT_EQ(x(30, 30), 5000.0);
  EXPECT_TRUE(std::isnan(x(25, 25)));
}

TEST(OrderRepair, ACyclicCodeMayLeadAcrossItsEnds) {
  // Word 31 of 32 read one period too high came out at the projector's other border.
  ImageD x = testing::ramp(40, 40, 1700.0, 1919.0);
  const double truth = x(38, 20);
  x(38, 20) += kPeriod - 32 * kPeriod;
  ImageD linear = x;
  EXPECT_EQ(repair_orders(linear, kOptions).n_changed, 0u);
  OrderRepairOptions o = kOptions;
  o.cycle_px = 32 * kPeriod;
  EXPECT_EQ(repair_orders(x, o).n_changed, 1u);
  EXPECT_NEAR(x(38, 20), truth, 1e-9);
}

TEST(OrderRepair, ResolverHasTheLastWord) {
  ImageD x = testing::ramp(40, 40, 0.0, 100.0);
  const double truth = x(20, 20);
  x(20, 20) += kPeriod;
  OrderRepairOptions o = kOptions;
  o.resolve = [](std::size_t, double) { return std::optional<double>(); };
  EXPECT_EQ(repair_orders(x, o).n_changed, 0u);
  o.resolve = [&](std::size_t, double) { return std::optional<double>(truth); };
  EXPECT_EQ(repair_orders(x, o).n_changed, 1u);
  EXPECT_EQ(x(20, 20), truth);
}

RC_GTEST_PROP(OrderRepair, OnlyWholePeriodsNearTheMajority, ()) {
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  std::uniform_real_distribution<double> jump(-2.0, 2.0), noise(-0.05, 0.05);
  ImageD x = testing::ramp(60, 30, 0.0, 300.0);
  for (double& v : x.data) v += kPeriod * (noise(random) + (random() % 10 == 0 ? jump(random) : 0.0));
  const ImageD before = x;
  const OrderRepair r = repair_orders(x, kOptions);
  std::uint64_t changed = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double periods = (x.data[i] - before.data[i]) / kPeriod;
    RC_ASSERT(std::fabs(periods - std::round(periods)) < 1e-9);
    changed += std::fabs(periods) > 0.5 ? 1u : 0u;
  }
  RC_ASSERT(changed <= r.n_changed);  // a pixel may have gone and come back
}

}  // namespace
}  // namespace fringetwin::measure::order_repair_test
