// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-6 rad   plane: float storage of the normal
//   2e-3 rad   sphere of 300 px radius, away from the rim: third-order terms of a 5x5 window
#include <gtest/gtest.h>

#include <cmath>

#include "measure/points/points.hpp"
#include "tests/support/measure/measure_rig.hpp"

namespace fringetwin::measure::normals_test {
namespace {

using namespace testing;

TEST(Normals, PlanesAndSpheres) {
  const Twin twin = scaled_paper_rig(0.5);
  const Eigen::Vector3d n = Eigen::Vector3d(0.4, -0.2, -1).normalized();
  PointCloud plane = triangulate_projector(twin, 0, ideal_decode(twin, 0, plane_surface({0, 0, 260}, n)));
  estimate_normals(plane, 720, 540, {0, 0, 0});
  for (const Eigen::Vector3f& normal : plane.normal_world)
    ASSERT_LT((normal.cast<double>() - n).norm(), 1e-6);

  const Eigen::Vector3d center(0, 0, 260);
  PointCloud ball = triangulate_projector(twin, 0, ideal_decode(twin, 0, sphere_surface(center, 30)));
  estimate_normals(ball, 720, 540, {0, 0, 0});
  std::size_t checked = 0;
  for (std::size_t i = 0; i < ball.size(); ++i) {
    const Eigen::Vector3d truth = (ball.p_world_mm[i] - center).normalized();
    if (truth.z() > -0.6) continue;
    ++checked;
    ASSERT_LT((ball.normal_world[i].cast<double>() - truth).norm(), 2e-3);
  }
  EXPECT_GT(checked, 20000u);
}

TEST(Normals, StepsDoNotBendThemAndLonelyPointsHaveNone) {
  const Twin twin = scaled_paper_rig(0.25);
  const RaySurface scene = nearest({sphere_surface({0, 0, 200}, 8), plane_surface({0, 0, 280}, {0, 0, -1})});
  PointCloud cloud = triangulate_projector(twin, 0, ideal_decode(twin, 0, scene));
  const std::size_t n = cloud.size();
  cloud.p_world_mm.push_back({0, 0, 250});  // alone, outside the lit area
  cloud.q_cam_px.push_back({-5, -5});
  cloud.sigma_mm.push_back(0.0f);
  estimate_normals(cloud, 360, 270, {0, 0, 0});
  ASSERT_EQ(cloud.normal_world.size(), n + 1);
  EXPECT_TRUE(std::isnan(cloud.normal_world[n].x()));
  for (std::size_t i = 0; i < n; ++i)
    if (cloud.p_world_mm[i].z() > 279.0) {
      ASSERT_LT((cloud.normal_world[i].cast<double>() - Eigen::Vector3d(0, 0, -1)).norm(), 1e-5);
    }
}

TEST(Normals, FaceTheViewer) {
  const Twin twin = scaled_paper_rig(0.1);
  PointCloud cloud =
      triangulate_projector(twin, 0, ideal_decode(twin, 0, plane_surface({0, 0, 260}, {0, 0, 1})));
  estimate_normals(cloud, 144, 108, {0, 0, 1000});  // seen from behind
  for (const Eigen::Vector3f& normal : cloud.normal_world) ASSERT_GT(normal.z(), 0.99f);
}

}  // namespace
}  // namespace fringetwin::measure::normals_test
