// SPDX-License-Identifier: Apache-2.0
// A gate that leaves out most of its object, or cuts through it, is told; one that holds the object is left
// in peace, whatever else stands there. The points are hits of rays with spheres and planes in closed form.
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

/// Adds the points of a scene as a camera in the origin sees it; `turned_deg`: by how much the rays are
/// turned from what the twin says.
void add_hits(const RaySurface& scene, PointCloud& cloud, double turned_deg = 0.0, double noise_mm = 0.0) {
  const Eigen::AngleAxisd turn(turned_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY());
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  for (int y = -60; y <= 60; ++y)
    for (int x = -80; x <= 80; ++x) {
      const Eigen::Vector3d ray = Eigen::Vector3d(x / 320.0, y / 320.0, 1.0).normalized();
      if (const auto at_mm = scene({0, 0, 0}, ray))
        cloud.p_world_mm.push_back(turn * ((*at_mm + noise_mm * normal(generator)) * ray));
    }
}

Camera camera_in_the_origin() {
  return {"left", Lens("LENSMODEL_PINHOLE", {320, 320, 80, 60}, {161, 121}, "test"), Pose{}, Sensor{},
          std::nullopt};
}

/// A ball before a wall.
struct Scene {
  Twin twin;
  PointCloud cloud;

  explicit Scene(double turned_deg, double noise_mm = 0.0) {
    twin.cameras.push_back(camera_in_the_origin());
    PlaneShape wall;
    wall.point_mm = {0, 0, 420};
    wall.normal = {0, 0, -1};
    twin.objects = {{"ball", SphereShape{{0, 0, 328.1}, 28.1}, {}}, {"wall", wall, {}}};
    twin.measure.fits = {{"ball", 2.0}, {"wall", 2.0}};
    add_hits(nearest({sphere_surface({0, 0, 328.1}, 28.1), plane_surface({0, 0, 420}, {0, 0, -1})}), cloud,
             turned_deg, noise_mm);
  }
  std::vector<std::string> told() const { return gate_warnings(twin, cloud, fit_objects(twin, cloud)); }
  /// Returns whether the fit passes without a ray being followed.
  bool is_cheap(std::size_t fit) const {
    const FitRequest& request = twin.measure.fits[fit];
    return points_gather_about(*twin.find_object(request.object), request.gate_mm, cloud,
                               fit_objects(twin, cloud)[fit]);
  }
};

/// A plane without an end, and a gate of 2 mm about it.
struct Table {
  Twin twin;
  PointCloud cloud;

  explicit Table(const RaySurface& scene) {
    twin.cameras.push_back(camera_in_the_origin());
    PlaneShape table;
    table.point_mm = {0, 0, 420};
    table.normal = {0, 0, -1};
    twin.objects = {{"table", table, {}}};
    twin.measure.fits = {{"table", 2.0}};
    add_hits(scene, cloud, 0.0, 0.1);
  }
  std::vector<std::string> told() const { return gate_warnings(twin, cloud, fit_objects(twin, cloud)); }
};
RaySurface table_surface(double z_mm = 420.0) { return plane_surface({0, 0, z_mm}, {0, 0, -1}); }

/// The part of a surface whose points lie on one side of a plane x = `end_mm`.
RaySurface left_of(double end_mm, const RaySurface& surface) {
  return [=](const Eigen::Vector3d& o, const Eigen::Vector3d& d) -> std::optional<double> {
    const auto at_mm = surface(o, d);
    return at_mm && (o + *at_mm * d).x() < end_mm ? at_mm : std::nullopt;
  };
}

TEST(GateWarnings, NoneOfARightTwin) {
  EXPECT_THAT(Scene(0.0).told(), IsEmpty());
  EXPECT_THAT(Scene(0.0, 0.3).told(), IsEmpty());
  EXPECT_THAT(Scene(0.05).told(), IsEmpty());  // 0.3 mm at the ball, well within the gate
}

// What a right twin costs is the distances of 300 points.
TEST(GateWarnings, NoRayIsFollowedOfARightTwin) {
  for (const std::size_t fit : {0u, 1u}) {
    EXPECT_TRUE(Scene(0.0).is_cheap(fit));
    EXPECT_TRUE(Scene(0.0, 0.3).is_cheap(fit));
  }
  EXPECT_FALSE(Scene(0.5).is_cheap(0));
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

// By 1.5, 3 and 7 gates towards the camera: farther off than the gate is wide, and told all the same.
TEST(GateWarnings, ABallThatIsDisplacedBySeveralGates) {
  for (const double nearer_mm : {3.0, 6.0, 14.0}) {
    Scene scene(0.0, 0.1);
    scene.twin.objects[0].shape = SphereShape{{0, 0, 328.1 - nearer_mm}, 28.1};
    EXPECT_THAT(scene.told(), ElementsAre(AllOf(HasSubstr("ball: "), HasSubstr("half lie more than"))))
        << nearer_mm;
  }
}

// 80 mm beside: no point within the gate, which the fit itself says.
TEST(GateWarnings, OneWhoseObjectIsElsewhereIsToldByTheFit) {
  Scene scene(0.0);
  scene.twin.objects[0].shape = SphereShape{{80, 0, 328.1}, 28.1};  // the camera sees the wall there
  const ObjectFit fit = fit_objects(scene.twin, scene.cloud)[0];
  EXPECT_FALSE(fit.usable);
  EXPECT_FALSE(fit.warning.empty());
  EXPECT_THAT(scene.told(), IsEmpty());
}

// Slabs that the twin lacks, on three quarters of the table's area: just above the gate, a few gates above,
// far above; and a ramp that rises from the table through the gate.
TEST(GateWarnings, ThingsOnATableThatTheTwinLacks) {
  for (const double above_mm : {3.0, 8.0, 15.0, 120.0}) {
    const Table table(nearest({left_of(50.0, table_surface(420.0 - above_mm)), table_surface()}));
    EXPECT_THAT(table.told(), IsEmpty()) << above_mm;
  }
  const RaySurface ramp =
      left_of(50.0, plane_surface({50, 0, 420}, Eigen::Vector3d(0.1, 0, -1).normalized()));
  EXPECT_THAT(Table(nearest({ramp, table_surface()})).told(), IsEmpty());
}

// The real table ends, a floor goes on 10 and 300 mm below: in the twin it is the table that goes on.
TEST(GateWarnings, ATableThatEndsBeforeItsPlaneDoes) {
  for (const double below_mm : {10.0, 300.0}) {
    const Table table(nearest({left_of(-40.0, table_surface()), table_surface(420.0 + below_mm)}));
    EXPECT_THAT(table.told(), IsEmpty()) << below_mm;
  }
}

// A table that is tilted by 3 degrees: the gate holds a stripe of it.
TEST(GateWarnings, ATableThatIsTilted) {
  const Table table(plane_surface({0, 0, 420}, Eigen::Vector3d(0.052, 0, -1).normalized()));
  EXPECT_THAT(table.told(), ElementsAre(AllOf(HasSubstr("table: "), HasSubstr("half lie more than"))));
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
