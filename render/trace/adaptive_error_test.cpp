// SPDX-License-Identifier: Apache-2.0
// The adaptive trace's error estimates on integrands with known integrals.
// | tolerance | origin                                                                        |
// | 1e-14     | rounding: Lobatto with four nodes is exact to degree 5                         |
// | bound     | true error <= estimate for kinks and smooth curves, <= 4 x estimate for jumps  |
#include "render/trace/adaptive_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace fringetwin::render::adaptive_error_test {
namespace {

const std::array<double, 4> nodes{-0.5, -0.5 * std::sqrt(0.2), 0.5 * std::sqrt(0.2), 0.5};

struct Panel {
  double value = 0.0, estimate = 0.0;
};
Panel panel(const std::function<double(double)>& f) {
  std::array<double, 4> g{};
  Panel p;
  for (std::size_t i = 0; i < 4; ++i) {
    g[i] = f(nodes[i]);
    p.value += kPanelWeights[i] * g[i];
  }
  p.estimate = panel_error(g);
  return p;
}

TEST(PanelError, LobattoIsExactToDegreeFive) {
  for (int degree = 0; degree <= 5; ++degree) {
    const Panel p = panel([&](double y) { return std::pow(y, degree); });
    const double exact = degree % 2 ? 0.0 : std::pow(0.5, degree) / (degree + 1);
    EXPECT_NEAR(p.value, exact, 1e-14) << degree;
  }
}

TEST(PanelError, NothingToFearFromAStraightLine) {
  EXPECT_NEAR(panel([](double y) { return 3.0 - 2.0 * y; }).estimate, 0.0, 1e-14);
}

TEST(PanelError, BoundsKinksAnywhere) {
  // max(0, y - a): integral (1/2 - a)^2 / 2. A region that only just enters a pixel's corner, and more.
  for (int i = 1; i < 1000; ++i) {
    const double a = -0.5 + i / 1000.0;
    const Panel p = panel([&](double y) { return std::max(0.0, y - a); });
    EXPECT_LE(std::abs(p.value - 0.5 * (0.5 - a) * (0.5 - a)), p.estimate + 1e-14) << a;
  }
}

TEST(PanelError, SeesJumpsAnywhere) {
  for (int i = 1; i < 1000; ++i) {
    const double a = -0.5 + i / 1000.0;
    const Panel p = panel([&](double y) { return y > a ? 1.0 : 0.0; });
    EXPECT_LE(std::abs(p.value - (0.5 - a)), 4.0 * p.estimate) << a;
    EXPECT_GT(p.estimate, 0.05) << a;
  }
}

TEST(Budget, KeepsTheSmallOnes) {
  EXPECT_DOUBLE_EQ(largest_error_to_keep({3.0, 1.0, 2.0}, 5.0, 10.0), 2.0);
  EXPECT_DOUBLE_EQ(largest_error_to_keep({3.0, 1.0, 2.0}, 100.0, 10.0), 3.0);
  EXPECT_DOUBLE_EQ(largest_error_to_keep({3.0, 1.0, 2.0}, 100.0, 1.5), 1.0);
  EXPECT_LT(largest_error_to_keep({3.0, 1.0}, 0.5, 10.0), 0.0);
  EXPECT_LT(largest_error_to_keep({NAN}, 10.0, 10.0), 0.0);
}

}  // namespace
}  // namespace fringetwin::render::adaptive_error_test
