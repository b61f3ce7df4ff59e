// SPDX-License-Identifier: Apache-2.0
// Where a refinement begins: every shape is found where the truth was planted, from points without noise.
// | check                          | tolerance | origin                                                    |
// |--------------------------------|-----------|-----------------------------------------------------------|
// | motions to a given place       | 1e-10 mm  | marks of 400 mm have roundings of 1e-13, turns over 100   |
// |                                |           | mm of 1e-15; Newton's steps shrink errors 1e4-fold each   |
// | places of sphere, plane, tube  | 1e-8 mm   | the fits find noiseless points to 1e-9 (fits_test.cpp)    |
// | place of the mesh              | 1e-5 mm   | its vertices are floats: 4e-6 at 30 mm                    |
#include "compare/refine/refine_start.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>

#include "tests/support/measure/test_meshes.hpp"

namespace fringetwin::compare::refine_start_test {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kBall = 0, kWall = 1, kTube = 2, kPart = 3;

/// A ball, a wall, a tube and a free-form part, far enough apart that no place is in doubt.
Twin scene() {
  PlaneShape wall;
  wall.point_mm = {3, -4, 400};
  wall.normal = Vector3d(0.1, -0.05, 1.0).normalized();  // away from the camera
  wall.u_axis = wall.normal.unitOrthogonal();
  CylinderShape tube;
  tube.point_mm = {90, 10, 290};
  tube.axis = Vector3d(0.1, 1, -0.1).normalized();
  tube.radius_mm = 12;
  MeshShape part;
  part.mesh = std::make_shared<const Mesh>(testing::bumpy_sphere(30, 40));
  part.T_world_object = pose_from_rt((RotTrans() << 0.3, -0.2, 0.5, 0, 5, 280).finished());
  Twin twin;
  twin.objects = {{"ball", SphereShape{{-90, -5, 270}, 19}, {}},
                  {"wall", wall, {}},
                  {"tube", tube, {}},
                  {"part", part, {}}};
  return twin;
}

/// The scene with everything 2 mm and 1 degree away from its place.
Twin displaced() {
  Twin truth = scene();
  const Eigen::AngleAxisd turn(0.0175, Vector3d(1, 2, -1).normalized());
  const Vector3d shift(1.2, -0.8, 1.4);
  std::get<SphereShape>(truth.objects[kBall].shape).center_mm += shift;
  auto& wall = std::get<PlaneShape>(truth.objects[kWall].shape);
  wall.point_mm += shift;
  wall.normal = turn * wall.normal;
  auto& tube = std::get<CylinderShape>(truth.objects[kTube].shape);
  tube.point_mm += shift;
  tube.axis = turn * tube.axis;
  auto& part = std::get<MeshShape>(truth.objects[kPart].shape);
  part.T_world_object.rotation = turn.toRotationMatrix() * part.T_world_object.rotation;
  part.T_world_object.translation_mm += shift;
  return truth;
}

/// Points on the sides of the displaced objects that look at a camera at the origin.
measure::PointCloud points() {
  const Twin truth = displaced();
  std::vector<Vector3d> p;
  const auto& ball = std::get<SphereShape>(truth.objects[kBall].shape);
  const auto& wall = std::get<PlaneShape>(truth.objects[kWall].shape);
  const auto& tube = std::get<CylinderShape>(truth.objects[kTube].shape);
  const auto& part = std::get<MeshShape>(truth.objects[kPart].shape);
  const Vector3d u = wall.normal.unitOrthogonal(), across = tube.axis.cross(Vector3d::UnitZ()).normalized();
  for (int i = -20; i <= 20; ++i)
    for (int j = -20; j <= 20; ++j) {
      const double a = 0.05 * i, b = 0.05 * j;
      p.push_back(ball.center_mm + ball.radius_mm * Vector3d(a, b, -1).normalized());
      p.push_back(wall.point_mm + 150 * (a * u + b * wall.normal.cross(u)));
      p.push_back(tube.point_mm + 40 * b * tube.axis +
                  tube.radius_mm * (Eigen::AngleAxisd(1.2 * a, tube.axis) * across.cross(tube.axis)));
    }
  for (const auto& t : part.mesh->triangles) {
    const auto corner = [&](int i) {
      return part.T_world_object * part.mesh->vertices_mm[t[i]].cast<double>();
    };
    const Vector3d middle = (corner(0) + corner(1) + corner(2)) / 3.0;
    if ((corner(1) - corner(0)).cross(corner(2) - corner(0)).dot(middle) < 0.0) p.push_back(middle);
  }
  measure::PointCloud cloud;
  cloud.p_world_mm = std::move(p);
  return cloud;
}

/// How far apart two shapes of a kind are: the largest distance of what tells their places, mm (directions
/// over an arm of 100 mm). Points on a plane or an axis count across it only.
double apart_mm(const SphereShape& a, const SphereShape& b) { return (a.center_mm - b.center_mm).norm(); }
double apart_mm(const PlaneShape& a, const PlaneShape& b) {
  return std::max(100 * (a.normal - b.normal).norm(), std::abs(b.normal.dot(a.point_mm - b.point_mm)));
}
double apart_mm(const CylinderShape& a, const CylinderShape& b) {
  return std::max(100 * (a.axis - b.axis).norm(), (a.point_mm - b.point_mm).cross(b.axis).norm());
}
double apart_mm(const MeshShape& a, const MeshShape& b) {
  return std::max(100 * (a.T_world_object.rotation - b.T_world_object.rotation).norm(),
                  (a.T_world_object.translation_mm - b.T_world_object.translation_mm).norm());
}
double apart_mm(const MeasuredShape&, const MeasuredShape&) { return 0.0; }
double apart_mm(const Shape& a, const Shape& b) {
  return std::visit([&]<class S>(const S& s) { return apart_mm(s, std::get<S>(b)); }, a);
}

TEST(RefineStart, MotionsBringEveryShapeToAPlace) {
  const Twin twin = scene(), truth = displaced();
  const std::vector<Parameter> parameters = parameters_of(twin, "pose");
  Eigen::VectorXd values = start_values(parameters);
  for (std::size_t k = 0; k < twin.objects.size(); ++k) {
    EXPECT_GT(apart_mm(twin.objects[k].shape, truth.objects[k].shape), 1.0);
    values = values_at(twin, parameters, values, {k, truth.objects[k].shape});
  }
  const Twin moved = with_values(twin, parameters, values);
  for (std::size_t k = 0; k < twin.objects.size(); ++k)
    EXPECT_LT(apart_mm(moved.objects[k].shape, truth.objects[k].shape), 1e-10) << twin.objects[k].name;
}

TEST(RefineStart, MotionsThatAreNotRefinedStay) {
  const Twin twin = scene();
  std::vector<Parameter> parameters;
  for (Parameter& p : parameters_of(twin, "pose"))
    if (p.name == "wall.offset_mm" || p.name == "ball.center_mm.x") parameters.push_back(std::move(p));
  ASSERT_EQ(parameters.size(), 2u);
  Twin truth = scene();
  auto& wall = std::get<PlaneShape>(truth.objects[kWall].shape);
  wall.point_mm += 2.5 * wall.normal;
  const Eigen::VectorXd values =
      values_at(twin, parameters, start_values(parameters), {kWall, truth.objects[kWall].shape});
  EXPECT_EQ(values[0], -90.0);
  EXPECT_NEAR(values[1], 2.5, 1e-10);
}

TEST(RefineStart, FitsFindEveryPlaceFarBeyondTheTwinsGate) {
  const Twin truth = displaced();
  Twin twin = scene();
  twin.measure.fits = {{"ball", 0.5}, {"wall", 0.5}};  // too narrow to find anything
  const std::vector<FittedPlace> places = fitted_places(twin, parameters_of(twin, "pose"), points());
  std::vector<double> nearest_mm(twin.objects.size(), 1e300);
  for (const FittedPlace& place : places)
    nearest_mm[place.object] =
        std::min(nearest_mm[place.object], apart_mm(place.shape, truth.objects[place.object].shape));
  EXPECT_LT(nearest_mm[kBall], 1e-8);
  EXPECT_LT(nearest_mm[kWall], 1e-8);
  EXPECT_LT(nearest_mm[kTube], 1e-8);
  EXPECT_LT(nearest_mm[kPart], 1e-5);
}

TEST(RefineStart, ObjectsThatAreNotRefinedAreNotFitted) {
  const Twin twin = scene();
  std::vector<Parameter> parameters = parameters_of(twin, "albedo");
  for (Parameter& p : parameters_of(twin, "pose"))
    if (p.name == "ball.center_mm.y") parameters.push_back(std::move(p));
  const std::vector<FittedPlace> places = fitted_places(twin, parameters, points());
  EXPECT_FALSE(places.empty());
  for (const FittedPlace& place : places) EXPECT_EQ(place.object, kBall);
  EXPECT_TRUE(fitted_places(twin, parameters, {}).empty());
}

}  // namespace
}  // namespace fringetwin::compare::refine_start_test
