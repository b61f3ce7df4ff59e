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

// The distance of two fits is the largest of all their differences, whichever it is.
TEST(Fits, DistanceTakesEveryDifference) {
  measure::ObjectFit a;
  a.object = "pin";
  a.kind = "cylinder";
  a.usable = true;
  a.vectors = {{"point_mm", {1, 2, 300}}, {"axis", {0, 1, 0}}};
  a.numbers = {{"radius_mm", 5.0}, {"rms_mm", 0.001}, {"mean_mm", 0.0}, {"p95_mm", 0.002}};
  for (const char* name : {"radius_mm", "rms_mm", "mean_mm", "p95_mm"}) {
    measure::ObjectFit b = a;
    b.numbers[name] += 0.003;
    EXPECT_NEAR(fit_distance_mm(a, b), 0.003, 1e-12) << name;
  }
  measure::ObjectFit b = a;
  b.vectors["point_mm"] = {1.003, 40, 299.996};  // along the axis does not matter
  EXPECT_NEAR(fit_distance_mm(a, b), 0.005, 1e-12);
}

TEST(Fits, ComeInTheOrderOfTheTwin) {
  Twin twin = testing::with_object(testing::paper_rig(), "ball", testing::physical_sphere());
  twin.measure.fits.resize(2);
  twin.measure.fits[0].object = "wall";
  twin.measure.fits[1].object = "ball";
  measure::Measurement measurement;
  measurement.fits.resize(3);
  measurement.fits[0].object = "ball";
  measurement.fits[1].object = "other";
  measurement.fits[2].object = "wall";
  const auto fits = fits_in_order(twin, measurement);
  ASSERT_EQ(fits.size(), 2u);
  EXPECT_EQ(fits[0].object, "wall");
  EXPECT_EQ(fits[1].object, "ball");
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
