// SPDX-License-Identifier: Apache-2.0
// A gate that leaves out most of its object, or cuts through it, is told; one that holds the object is left
// in peace. The points are hits of rays with spheres and planes in closed form.
#include "measure/fit/gate_warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "measure/fit/object_fits.hpp"
#include "tests/support/measure/measure_rig.hpp"
#include "tests/support/measure/test_meshes.hpp"

namespace fringetwin::measure::gate_warnings_test {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A ball before a wall, as a camera in the origin sees them; `turned_deg`: by how much the rays are turned
/// from what the twin says.
struct Scene {
  Twin twin;
  PointCloud cloud;

  explicit Scene(double turned_deg, double noise_mm = 0.0) {
    twin.cameras.push_back({"left", Lens("LENSMODEL_PINHOLE", {320, 320, 80, 60}, {161, 121}, "test"), Pose{},
                            Sensor{}, std::nullopt});
    PlaneShape wall;
    wall.point_mm = {0, 0, 420};
    wall.normal = {0, 0, -1};
    twin.objects = {{"ball", SphereShape{{0, 0, 328.1}, 28.1}, {}}, {"wall", wall, {}}};
    twin.measure.fits = {{"ball", 2.0}, {"wall", 2.0}};
    const RaySurface surfaces =
        nearest({sphere_surface({0, 0, 328.1}, 28.1), plane_surface({0, 0, 420}, {0, 0, -1})});
    const Eigen::AngleAxisd turn(turned_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY());
    std::mt19937 generator(7);
    std::normal_distribution<double> noise(0.0, noise_mm > 0.0 ? noise_mm : 1.0);
    for (int y = -60; y <= 60; ++y)
      for (int x = -80; x <= 80; ++x) {
        const Eigen::Vector3d ray = Eigen::Vector3d(x / 320.0, y / 320.0, 1.0).normalized();
        const auto at_mm = surfaces({0, 0, 0}, ray);
        if (at_mm)
          cloud.p_world_mm.push_back(turn * ((*at_mm + (noise_mm > 0.0 ? noise(generator) : 0.0)) * ray));
      }
  }
  std::vector<std::string> told() const { return gate_warnings(twin, cloud, fit_objects(twin, cloud)); }
};

TEST(GateWarnings, NoneOfARightTwin) {
  EXPECT_THAT(Scene(0.0).told(), IsEmpty());
  EXPECT_THAT(Scene(0.0, 0.3).told(), IsEmpty());
  EXPECT_THAT(Scene(0.05).told(), IsEmpty());  // 0.3 mm at the ball, well within the gate
}

// 0.5 degrees are 2.9 mm at the ball and up to 1 mm at the wall (0.25 of its distance times 0.0087).
TEST(GateWarnings, ABallThatLiesOutsideItsGate) {
  Scene scene(0.5);
  scene.twin.objects[0].shape = SphereShape{{0, 0, 322.1}, 28.1};  // and 6 mm nearer
  EXPECT_THAT(scene.told(), ElementsAre(AllOf(HasSubstr("ball: "), HasSubstr("points lie within gate_mm = 2"),
                                              HasSubstr("take a larger gate_mm"))));
  scene.twin.measure.fits[0].gate_mm = 20.0;
  EXPECT_THAT(scene.told(), IsEmpty());
}

// A ball turned by 0.5 degrees lies up to 2.9 mm beside the twin's, so that a gate of 1.2 mm holds more than
// half of its points and ends within them.
TEST(GateWarnings, AGateThatCutsThroughTheBall) {
  Scene scene(0.5);
  scene.twin.measure.fits[0].gate_mm = 1.2;
  EXPECT_THAT(scene.told(), ElementsAre(AllOf(HasSubstr("ball: "), HasSubstr("cuts through the object"))));
}

TEST(GateWarnings, OneWhoseObjectIsElsewhere) {
  Scene scene(0.0);
  scene.twin.objects[0].shape = SphereShape{{80, 0, 328.1}, 28.1};  // the camera sees the wall there
  EXPECT_THAT(scene.told(), ElementsAre(AllOf(HasSubstr("ball: 0 points"), HasSubstr("half lie more than"))));
}

TEST(GateWarnings, AMeshIsJudgedAsTheBallIs) {
  Scene scene(0.0);
  MeshShape ball;
  ball.mesh = std::make_shared<const Mesh>(bumpy_sphere(28.1, 40));
  ball.T_world_object.translation_mm = {0, 0, 328.1};
  scene.twin.objects[0].shape = ball;
  scene.twin.measure.fits = {{"ball", 20.0}};
  EXPECT_THAT(scene.told(), IsEmpty());
  ball.T_world_object.translation_mm = {0, 0, 318.1};
  scene.twin.objects[0].shape = ball;
  scene.twin.measure.fits = {{"ball", 2.0}};
  EXPECT_THAT(scene.told(), ElementsAre(HasSubstr("ball: ")));
}

TEST(GateWarnings, NoneWhereAnObjectHasNoNominalSurface) {
  Scene scene(0.5);
  scene.twin.objects[0].shape = SphereShape{{0, 0, 318.1}, 28.1};
  scene.twin.objects.push_back({"part", MeasuredShape{}, {}});
  EXPECT_THAT(scene.told(), IsEmpty());
}

}  // namespace
}  // namespace fringetwin::measure::gate_warnings_test
