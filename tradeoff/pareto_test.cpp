// SPDX-License-Identifier: Apache-2.0
// No tolerances: marks and counts.
#include "tradeoff/pareto.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fringetwin::tradeoff::pareto_test {
namespace {

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
}  // namespace fringetwin::tradeoff::pareto_test
