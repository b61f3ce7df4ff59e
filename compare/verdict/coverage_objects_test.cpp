// SPDX-License-Identifier: Apache-2.0
// No tolerances: indices of points.
#include "compare/verdict/coverage_objects.hpp"

#include <gtest/gtest.h>

namespace fringetwin::compare::coverage_objects_test {
namespace {

/// Two cameras of 40 x 30 px; the second one stands 50 mm to the right of the first and looks along the same
/// way.
Twin two_cameras() {
  const Lens lens("LENSMODEL_PINHOLE", {100.0, 100.0, 20.0, 15.0}, {40, 30}, "test");
  Twin twin;
  twin.cameras.resize(2, Camera{"left", lens, Pose{}, Sensor{}, std::nullopt});
  twin.cameras[1].T_cam_world.translation_mm = {-50.0, 0.0, 0.0};
  return twin;
}

/// Returns the point that the second camera sees in a pixel at that depth: q = 100 x/z + (20, 15).
Eigen::Vector3d seen_at(double x_px, double y_px, double z_mm) {
  return {50.0 + (x_px - 20.0) * z_mm / 100.0, (y_px - 15.0) * z_mm / 100.0, z_mm};
}

// Of two points in one pixel the nearer one hides the other, whichever comes first.
TEST(CoverageObjects, TheNearestPointIsSeen) {
  measure::PointCloud cloud;
  cloud.p_world_mm = {seen_at(7, 22, 300), seen_at(7, 22, 250), seen_at(31, 4, 260),
                      seen_at(31, 4, 310), seen_at(40, 4, 260), seen_at(12, -1, 260)};
  cloud.q_cam_px.assign(cloud.p_world_mm.size(), {3.0F, 2.0F});
  const Image<int> index = points_of_pixels(two_cameras(), 1, cloud);
  EXPECT_EQ(index(7, 22), 1);
  EXPECT_EQ(index(31, 4), 2);
  int n = 0;
  for (const int i : index.data) n += i >= 0;
  EXPECT_EQ(n, 2) << "two points are outside the image";
}

// The first camera's points know their pixels.
TEST(CoverageObjects, TheFirstCameraSeesItsOwnPoints) {
  measure::PointCloud cloud;
  cloud.p_world_mm = {seen_at(7, 22, 300), seen_at(31, 4, 260)};
  cloud.q_cam_px = {{3.0F, 2.0F}, {5.0F, 29.0F}};
  const Image<int> index = points_of_pixels(two_cameras(), 0, cloud);
  EXPECT_EQ(index(3, 2), 0);
  EXPECT_EQ(index(5, 29), 1);
}

}  // namespace
}  // namespace fringetwin::compare::coverage_objects_test
