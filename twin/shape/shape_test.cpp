// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-12 mm    rounding of unit vectors and turns at coordinates of 300 mm
#include "twin/shape/shape.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <string>

namespace fringetwin::shape_test {
namespace {

using ::testing::DoubleNear, ::testing::IsSupersetOf, ::testing::Pointwise;

TEST(Shape, EveryShapeHasAKindOfItsOwn) {
  std::set<std::string> kinds;
  int n = 0;
  for_every_shape([&](const auto& s) {
    ++n;
    kinds.insert(shape_kind(Shape(s)));
    EXPECT_STREQ(shape_kind(Shape(s)), s.kKind);
  });
  EXPECT_EQ(n, static_cast<int>(std::variant_size_v<Shape>));
  EXPECT_EQ(kinds.size(), std::variant_size_v<Shape>);
  EXPECT_THAT(kinds, IsSupersetOf({"sphere", "plane", "cylinder", "mesh", "measured"}));
}

// Whatever moves a shape changes a key that places it, and back again it is where it was.
TEST(Shape, EveryMotionChangesAPlaceKeyAndBack) {
  for_every_shape([]<class S>(const S& at_rest) {
    const auto values = [](const S& s) {
      std::vector<double> out;
      for (const PlaceKey& k : place_keys(s)) out.insert(out.end(), k.values.begin(), k.values.end());
      return out;
    };
    for (const Motion<S>& motion : motions(at_rest)) {
      S moved = at_rest;
      motion.move_by(moved, 0.25);
      make_units(moved);
      EXPECT_NE(values(moved), values(at_rest)) << S::kKind << " " << motion.name;
      S back = at_rest;
      motion.move_by(back, 0.25);
      motion.move_by(back, -0.25);
      make_units(back);
      EXPECT_THAT(values(back), Pointwise(DoubleNear(1e-12), values(at_rest)))
          << S::kKind << " " << motion.name;
    }
  });
}

TEST(Shape, MotionsShiftASphereAlongTheAxes) {
  SphereShape sphere{{1, 2, 300}, 5.0};
  const auto all = motions(sphere);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[2].name, "center_mm.z");
  EXPECT_EQ(all[2].start, 300.0);
  all[2].move_by(sphere, 0.25);
  EXPECT_EQ(sphere.center_mm, Eigen::Vector3d(1, 2, 300.25));
}

TEST(Shape, ATiltedPlaneKeepsItsPointAndUnitVectors) {
  PlaneShape plane{
      {0, 0, 300}, Eigen::Vector3d(0.3, 0.1, -1).normalized(), Eigen::Vector2d(10, 20), {1, 0, 0}};
  make_units(plane);
  const Eigen::Vector3d before = plane.normal;
  const auto all = motions(plane);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[1].unit, "rad");
  all[1].move_by(plane, 1e-3);
  make_units(plane);
  EXPECT_EQ(plane.point_mm, Eigen::Vector3d(0, 0, 300));
  EXPECT_NEAR(std::acos(plane.normal.dot(before)), std::atan(1e-3),
              1e-9);  // acos near 1 keeps half the digits
  EXPECT_NEAR(plane.normal.norm(), 1.0, 1e-12);
  EXPECT_NEAR(plane.u_axis.dot(plane.normal), 0.0, 1e-12);
  all[0].move_by(plane, 2.0);
  EXPECT_NEAR((plane.point_mm - Eigen::Vector3d(0, 0, 300)).dot(before), 2.0, 1e-12);
}

TEST(Shape, AMeshTurnsAboutTheMeanOfItsVertices) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices_mm = {{-1, 0, 0}, {3, 0, 0}, {1, 3, 0}, {1, -3, 0}};
  MeshShape shape{{}, "mm", {Eigen::Matrix3d::Identity(), {0, 0, 300}}, false, mesh};
  const Eigen::Vector3d middle = shape.T_world_object * Eigen::Vector3d(1, 0, 0);
  const auto all = motions(shape);
  ASSERT_EQ(all.size(), 6U);
  all[5].move_by(shape, 0.1);
  EXPECT_NEAR((shape.T_world_object * Eigen::Vector3d(1, 0, 0) - middle).norm(), 0.0, 1e-12);
  EXPECT_NEAR((shape.T_world_object * Eigen::Vector3d(3, 0, 0)).y(), 2.0 * std::sin(0.1), 1e-12);
}

TEST(Shape, PlaceKeysAreThoseOfTheTwinFile) {
  const auto names = [](const Shape& shape) {
    std::vector<std::string> out;
    for (const PlaceKey& k : std::visit([](const auto& s) { return place_keys(s); }, shape))
      out.push_back(k.key);
    return out;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(names(SphereShape{}), (Names{"center_mm"}));
  EXPECT_EQ(names(PlaneShape{}), (Names{"point_mm", "normal"}));
  EXPECT_EQ(names(PlaneShape{.size_mm = Eigen::Vector2d(1, 2)}), (Names{"point_mm", "normal", "u_axis"}));
  EXPECT_EQ(names(CylinderShape{}), (Names{"point_mm", "axis"}));
  EXPECT_EQ(names(MeshShape{}), (Names{"rt_world_object"}));
  EXPECT_EQ(names(MeasuredShape{}), Names{});
}

TEST(Shape, OnlyWhatOneCanSeeIntoShadesItself) {
  EXPECT_FALSE(shades_itself(Shape(SphereShape{})));
  EXPECT_FALSE(shades_itself(Shape(PlaneShape{})));
  EXPECT_FALSE(shades_itself(Shape(CylinderShape{})));
  EXPECT_TRUE(shades_itself(Shape(CylinderShape{.length_mm = 10.0})));
  EXPECT_TRUE(shades_itself(Shape(MeshShape{})));
}

TEST(Shape, FilesAreThoseThatTheShapeIsReadFrom) {
  EXPECT_TRUE(shape_files(Shape(SphereShape{})).empty());
  MeshShape mesh;
  mesh.file = "part.stl";
  EXPECT_EQ(shape_files(Shape(mesh)), (std::vector<std::filesystem::path>{"part.stl"}));
  PlaneShape plane;
  plane.albedo_file = "map.png";
  EXPECT_EQ(shape_files(Shape(plane)), (std::vector<std::filesystem::path>{"map.png"}));
}

}  // namespace
}  // namespace fringetwin::shape_test
