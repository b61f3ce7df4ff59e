// SPDX-License-Identifier: Apache-2.0
// Truth: coordinates set by hand, so every number has a closed form.
// | check              | tolerance | origin                              |
// |--------------------|-----------|-------------------------------------|
// | mean, rms, ratio   | 1e-12 rad | double sums; differences are float only in the percentile |
// | p99                | 1 % of rms | histogram of 4096 bins              |
#include "compare/phase/phase_rows.hpp"

#include <gtest/gtest.h>

#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::phase_rows_test {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

struct Sides {
  Twin twin;
  measure::Measurement real, simulated;
};

Sides make_sides(double shift_px) {
  testing::SidesTruth t;
  testing::SyntheticSides scene = testing::make_sides(t);
  Sides s{scene.twin, *scene.real.measurement, *scene.simulated.measurement};
  s.real = s.simulated;
  for (double& x : s.simulated.cameras[0].directions[0].coordinate_px.data) x += shift_px;
  return s;
}

TEST(PhaseRows, ConstantShiftHasClosedForm) {
  Sides s = make_sides(0.02);
  s.twin.fringes.directions[0].phase_origin_px = {20.0, 25.0, 30.0};
  const std::vector<PhaseRow> rows = phase_rows(s.twin, s.real, s.simulated);
  ASSERT_EQ(rows.size(), 1u);
  const double expected = kTwoPi * 0.02 / 13.0;  // the finest of 13, 14, 15
  EXPECT_NEAR(rows[0].mean_rad, expected, 1e-12);
  EXPECT_NEAR(rows[0].rms_rad, expected, 1e-12);
  EXPECT_NEAR(rows[0].p99_rad, expected, 0.01 * expected);
  double sum = 0, n = 0;
  for (double x : s.real.cameras[0].directions[0].coordinate_px.data)
    if (!std::isnan(x)) sum += std::abs(kTwoPi * (x - 20.0) / 13.0), n += 1;
  EXPECT_NEAR(rows[0].mean_relative, expected / (sum / n), 1e-12);
  EXPECT_EQ(rows[0].n, static_cast<std::uint64_t>(n));
  EXPECT_EQ(rows[0].camera, "left");
  EXPECT_EQ(rows[0].direction, "x");
}

TEST(PhaseRows, OrderDisagreementsAreCountedApart) {
  Sides s = make_sides(0.0);
  ImageD& x = s.simulated.cameras[0].directions[0].coordinate_px;
  x(96, 80) += 13.0;  // one whole period
  x(97, 80) -= 7.0;   // more than half a period
  x(98, 80) += 6.0;   // less than half: a difference, not an order
  const PhaseRow row = phase_rows(s.twin, s.real, s.simulated).at(0);
  EXPECT_EQ(row.n_order_disagree, 2u);
  EXPECT_DOUBLE_EQ(row.order_disagree_fraction(), 2.0 / static_cast<double>(row.n + 2));
  EXPECT_NEAR(row.mean_rad * static_cast<double>(row.n), kTwoPi * 6.0 / 13.0, 1e-9);
  const ImageF d = phase_difference(s.real.cameras[0].directions[0], s.simulated.cameras[0].directions[0]);
  EXPECT_TRUE(std::isnan(d(96, 80)));
  EXPECT_NEAR(static_cast<double>(d(98, 80)), kTwoPi * 6.0 / 13.0, 1e-6);
}

TEST(PhaseRows, ManyDisagreementsAreAWarning) {
  testing::SyntheticSides scene = testing::make_sides({});
  const auto warned = [&] {
    for (const std::string& w : compare(scene.twin, scene.real, scene.simulated, {}).warnings)
      if (w.find("fringe orders disagree") != std::string::npos) return true;
    return false;
  };
  EXPECT_FALSE(warned());
  for (double& x : scene.simulated.measurement->cameras[0].directions[0].coordinate_px.data) x += 13.0;
  EXPECT_TRUE(warned());
}

TEST(PhaseRows, PixelsInvalidOnOneSideAreLeftOut) {
  Sides s = make_sides(0.1);
  const std::uint64_t all = phase_rows(s.twin, s.real, s.simulated).at(0).n;
  s.real.cameras[0].directions[0].coordinate_px(96, 80) = std::nan("");
  s.simulated.cameras[0].directions[0].coordinate_px(90, 80) = std::nan("");
  EXPECT_EQ(phase_rows(s.twin, s.real, s.simulated).at(0).n, all - 2);
}

TEST(PhaseRows, NoCommonPixelGivesNoNumber) {
  Sides s = make_sides(0.1);
  auto& x = s.real.cameras[0].directions[0].coordinate_px.data;
  std::fill(x.begin(), x.end(), std::nan(""));
  const PhaseRow row = phase_rows(s.twin, s.real, s.simulated).at(0);
  EXPECT_EQ(row.n, 0u);
  EXPECT_TRUE(std::isnan(row.rms_rad));
  EXPECT_TRUE(std::isnan(row.mean_relative));
}

TEST(PhaseRows, AbsolutePhaseStartsAtTheOrigin) {
  Sides s = make_sides(0.0);
  s.twin.fringes.directions[0].phase_origin_px = {30, 30, 30};
  const auto& d = s.real.cameras[0].directions[0];
  const ImageF phase = absolute_phase(s.twin, d);
  EXPECT_NEAR(static_cast<double>(phase(96, 80)), kTwoPi * (d.coordinate_px(96, 80) - 30.0) / 13.0, 1e-4);
}

}  // namespace
}  // namespace fringetwin::compare::phase_rows_test
