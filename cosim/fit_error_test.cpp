// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit | origin                        |
// |-----------|------|-------------------------------|
// | 1e-12     | mm   | closed forms, double rounding |
#include "cosim/fit_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/paper_rig.hpp"

namespace fringetwin::cosim::fit_error_test {
namespace {

TEST(Fits, DistanceAndErrorOfASphere) {
  measure::ObjectFit a;
  a.object = "ball";
  a.kind = "sphere";
  a.usable = true;
  a.vectors["center_mm"] = {1, 2, 3};
  a.numbers = {{"radius_mm", 5.0}, {"rms_mm", 0.001}};
  measure::ObjectFit b = a;
  b.vectors["center_mm"] = {1.0003, 2.0004, 3};
  EXPECT_NEAR(fit_distance_mm(a, b), 5e-4, 1e-12);
  b = a;
  b.numbers["radius_mm"] = 5.002;
  EXPECT_NEAR(fit_distance_mm(a, b), 2e-3, 1e-12);
  b = a;
  b.numbers["rms_mm"] = 0.004;
  EXPECT_NEAR(fit_distance_mm(a, b), 3e-3, 1e-12);
  b.usable = false;
  EXPECT_TRUE(std::isinf(fit_distance_mm(a, b)));

  Twin twin = testing::with_object(testing::paper_rig(), "ball", SphereShape{{1, 2, 3.004}, 5.0});
  EXPECT_NEAR(fit_error_mm(twin, a), 4e-3, 1e-12) << "the residual rms is no error of place or size";
  a.usable = false;
  EXPECT_TRUE(std::isnan(fit_error_mm(twin, a)));
}

TEST(Fits, ErrorOfAPlaneIsItsOffset) {
  measure::ObjectFit fit;
  fit.object = "wall";
  fit.kind = "plane";
  fit.usable = true;
  fit.vectors["point_mm"] = {40, -20, 300.007};  // where on the plane does not matter
  fit.vectors["normal"] = {0, 0, -1};
  fit.numbers["rms_mm"] = 0.1;
  const Twin twin = testing::with_object(testing::paper_rig(), "wall", testing::frontal_plane());
  EXPECT_NEAR(fit_error_mm(twin, fit), 7e-3, 1e-12);
}

}  // namespace
}  // namespace fringetwin::cosim::fit_error_test
