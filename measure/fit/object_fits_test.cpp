// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   1e-9 mm   noiseless points through exact fits (see fits_test.cpp); result keys are a contract
//   (docs/result.schema.json)
#include "measure/fit/object_fits.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/support/measure/measure_rig.hpp"
#include "tests/support/measure/test_meshes.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure::object_fits_test {
namespace {

using namespace testing;

Object named(const std::string& name, Shape shape) { return {name, std::move(shape), {}}; }

TEST(SurfaceDistance, ClosedForms) {
  const Object ball = named("b", SphereShape{{0, 0, 250}, 5});
  EXPECT_NEAR(surface_distance_mm(ball, {0, 0, 240}), 5.0, 1e-12);
  EXPECT_NEAR(surface_distance_mm(ball, {0, 1, 250}), -4.0, 1e-12);
  PlaneShape wall;
  wall.point_mm = {0, 0, 250};
  wall.normal = {0, 0, -1};
  EXPECT_NEAR(surface_distance_mm(named("w", wall), {1000, 5, 248}), 2.0, 1e-12);
  EXPECT_NEAR(surface_distance_mm(named("w", wall), {0, 0, 251}), -1.0, 1e-12);
  wall.size_mm = Eigen::Vector2d(20, 10);
  EXPECT_NEAR(surface_distance_mm(named("w", wall), {13, 9, 250}), 5.0, 1e-12);  // 3 and 4 beside it
  CylinderShape pipe;
  pipe.point_mm = {0, 0, 250};
  pipe.axis = {0, 1, 0};
  pipe.radius_mm = 10;
  EXPECT_NEAR(surface_distance_mm(named("p", pipe), {0, 99, 238}), 2.0, 1e-12);
  pipe.length_mm = 20;
  EXPECT_NEAR(surface_distance_mm(named("p", pipe), {0, 14, 237}), 5.0, 1e-12);
  MeshShape mesh;
  mesh.mesh = std::make_shared<const Mesh>(square(10));
  mesh.T_world_object = pose_from_rt((RotTrans() << 0, 0, 0, 1, 2, 250).finished());
  EXPECT_NEAR(surface_distance_mm(named("m", mesh), {1, 2, 251.5}), 1.5, 1e-12);
  EXPECT_TRUE(std::isnan(surface_distance_mm(named("x", MeasuredShape{}), {0, 0, 0})));
}

struct Bench {
  Twin twin = scaled_paper_rig(0.25);
  PointCloud cloud;

  Bench() {
    const RaySurface scene =
        nearest({sphere_surface({-20, 0, 240}, 10), cylinder_surface({20, 0, 250}, {0, 1, 0}, 8),
                 plane_surface({0, 0, 290}, Eigen::Vector3d(0.1, 0, -1).normalized())});
    cloud = triangulate_projector(twin, 0, ideal_decode(twin, 0, scene));
    PlaneShape wall;
    wall.point_mm = {0.5, 0, 290.3};
    wall.normal = {0.1, 0, -1};
    wall.normal.normalize();
    CylinderShape pipe;
    pipe.point_mm = {20.3, 5, 250.2};
    pipe.axis = {0, 1, 0};
    pipe.radius_mm = 8.2;
    twin.objects = {named("ball", SphereShape{{-20.2, 0.1, 240.3}, 9.9}), named("pipe", pipe),
                    named("wall", wall), named("missing", SphereShape{{0, 200, 250}, 5})};
    twin.measure.fits = {{"ball", 1.0}, {"pipe", 1.0}, {"wall", 2.0}, {"missing", 1.0}};
  }
};

// Every fiftieth point of the ball stands 0.6 mm out, most of them within the gate of 1 mm: none is used.
TEST(FitObjects, OutliersHaveNoDeviation) {
  Bench bench;
  const ObjectFit clean = fit_objects(bench.twin, bench.cloud).at(0);
  for (std::size_t k = 0; k < clean.index.size(); k += 50) {
    Eigen::Vector3d& p_mm = bench.cloud.p_world_mm[clean.index[k]];
    p_mm += 0.6 * (p_mm - Eigen::Vector3d(-20, 0, 240)).normalized();
  }
  const ObjectFit ball = fit_objects(bench.twin, bench.cloud).at(0);
  ASSERT_TRUE(ball.usable) << ball.warning;
  EXPECT_LT(ball.n, static_cast<std::size_t>(ball.numbers.at("n_gated"))) << "some outliers are gated";
  EXPECT_EQ(ball.index.size(), ball.n);
  EXPECT_EQ(ball.deviation_mm.size(), ball.n);
  for (const float deviation_mm : ball.deviation_mm) ASSERT_LT(std::abs(deviation_mm), 1e-6F);
}

TEST(FitObjects, EveryShapeIsFoundInOneScene) {
  const Bench bench;
  const auto rows = fit_objects(bench.twin, bench.cloud);
  ASSERT_EQ(rows.size(), 4u);
  const ObjectFit &ball = rows[0], &pipe = rows[1], &wall = rows[2], &missing = rows[3];
  EXPECT_EQ(ball.kind, "sphere");
  ASSERT_TRUE(ball.usable) << ball.warning;
  EXPECT_LT((ball.vectors.at("center_mm") - Eigen::Vector3d(-20, 0, 240)).norm(), 1e-9);
  EXPECT_NEAR(ball.numbers.at("radius_mm"), 10.0, 1e-9);
  EXPECT_LT(ball.numbers.at("rms_mm"), 1e-9);
  EXPECT_TRUE(ball.vectors.contains("center_sigma_mm") && ball.numbers.contains("radius_sigma_mm"));
  ASSERT_TRUE(pipe.usable) << pipe.warning;
  EXPECT_NEAR(pipe.numbers.at("radius_mm"), 8.0, 1e-8);
  EXPECT_LT((pipe.vectors.at("axis") - Eigen::Vector3d(0, 1, 0)).norm(), 1e-9);
  EXPECT_TRUE(pipe.numbers.contains("radius_sigma_mm"));
  ASSERT_TRUE(wall.usable) << wall.warning;
  const Eigen::Vector3d n = Eigen::Vector3d(0.1, 0, -1).normalized();
  EXPECT_LT((wall.vectors.at("normal") - n).norm(), 1e-10);
  EXPECT_LT(std::abs(n.dot(wall.vectors.at("point_mm") - Eigen::Vector3d(0, 0, 290))), 1e-9);
  for (const char* key : {"offset_sigma_mm", "tilt_sigma_rad_0", "tilt_sigma_rad_1"})
    EXPECT_TRUE(wall.numbers.contains(key));
  // across the normal, the first near the nominal plane's u axis, x
  EXPECT_LT((wall.vectors.at("tilt_direction_0") - Eigen::Vector3d(1, 0, 0.1).normalized()).norm(), 1e-9);
  EXPECT_LT((wall.vectors.at("tilt_direction_1") - Eigen::Vector3d(0, -1, 0)).norm(), 1e-9);
  for (const char* key : {"axis_sigma_rad_0", "axis_sigma_rad_1", "axis_shift_sigma_mm_0"})
    EXPECT_TRUE(pipe.numbers.contains(key));
  for (const ObjectFit* row : {&ball, &pipe, &wall}) {
    EXPECT_EQ(row->index.size(), row->n);
    EXPECT_EQ(row->deviation_mm.size(), row->n);
    EXPECT_GT(row->n, 500u);
    EXPECT_TRUE(std::is_sorted(row->index.begin(), row->index.end()));
    EXPECT_LT(row->index.back(), bench.cloud.size());
  }
  EXPECT_FALSE(missing.usable);
  EXPECT_EQ(missing.n, 0u);
  EXPECT_FALSE(missing.warning.empty());
  EXPECT_TRUE(std::isnan(missing.numbers.at("radius_mm")));
}

TEST(FitObjects, OutliersStayInTheUntrimmedRms) {
  Bench bench;
  bench.twin.objects = {named("ball", SphereShape{{-20, 0, 240}, 10})};
  bench.twin.measure.fits = {{"ball", 2.0}};
  std::size_t moved = 0, on_ball = 0;
  for (std::size_t i = 0; i < bench.cloud.size(); ++i) {
    Eigen::Vector3d& p = bench.cloud.p_world_mm[i];
    const Eigen::Vector3d d = p - Eigen::Vector3d(-20, 0, 240);
    if (std::abs(d.norm() - 10) > 1e-3) continue;
    ++on_ball;
    if (on_ball % 20 != 0) continue;
    p += 0.5 * d.normalized();
    ++moved;
  }
  const ObjectFit row = fit_objects(bench.twin, bench.cloud).at(0);
  EXPECT_EQ(row.numbers.at("n_gated"), static_cast<double>(on_ball));
  EXPECT_EQ(row.n, on_ball - moved);
  EXPECT_LT(row.numbers.at("rms_mm"), 1e-6);
  EXPECT_NEAR(row.numbers.at("rms_all_mm"),
              0.5 * std::sqrt(static_cast<double>(moved) / static_cast<double>(on_ball)), 1e-6);
}

TEST(FitObjects, EnoughPointsWithoutAFitKeepTheirNumber) {
  // points of a plane within the gate of a sphere and a cylinder that touch it
  Bench bench;
  bench.twin.objects = {named("ball", SphereShape{{0, 0, 250}, 40}),
                        named("pipe", CylinderShape{{0, 0, 250}, {0, 1, 0}, 40, {}})};
  bench.twin.measure.fits = {{"ball", 2.0}, {"pipe", 2.0}};
  PointCloud wall;
  for (int y = -40; y <= 40; ++y)
    for (int x = -40; x <= 40; ++x)
      wall.p_world_mm.push_back({0.2 * x, 0.2 * y, 210.0 + 1e-4 * ((x * y) % 3)});
  for (const ObjectFit& row : fit_objects(bench.twin, wall)) {
    EXPECT_FALSE(row.usable) << row.object;
    EXPECT_GT(row.n, 20u) << row.object << ": " << row.warning;
  }
}

TEST(FitObjects, IndexNamesThePointsOfTheObject) {
  const Bench bench;
  const auto rows = fit_objects(bench.twin, bench.cloud);
  for (std::size_t k = 0; k < rows[0].n; ++k) {
    const double d = (bench.cloud.p_world_mm[rows[0].index[k]] - rows[0].vectors.at("center_mm")).norm() -
                     rows[0].numbers.at("radius_mm");
    ASSERT_NEAR(d, static_cast<double>(rows[0].deviation_mm[k]), 1e-9);
  }
}

TEST(FitObjects, MeshRowHasItsKeys) {
  Bench bench;
  MeshShape cad;
  cad.mesh = std::make_shared<const Mesh>(bumpy_sphere(10, 40));
  cad.T_world_object.translation_mm = {0, 0, 250};
  PointCloud cloud;
  for (const auto& v : cad.mesh->vertices_mm)
    if (v.z() < 0)
      cloud.p_world_mm.push_back(cad.T_world_object * v.cast<double>() + Eigen::Vector3d(0.1, 0, 0));
  bench.twin.objects = {named("part", cad), named("surface", MeasuredShape{})};
  bench.twin.measure.fits = {{"part", 2.0}, {"surface", 2.0}};
  const auto rows = fit_objects(bench.twin, cloud);
  ASSERT_TRUE(rows[0].usable) << rows[0].warning;
  EXPECT_EQ(rows[0].kind, "mesh");
  for (const char* key : {"rms_mm", "within_10um", "mean_mm", "p95_mm"})
    EXPECT_TRUE(rows[0].numbers.contains(key)) << key;
  EXPECT_NEAR(rows[0].vectors.at("T_object_measured_t_mm").x(), -0.1, 0.01);
  EXPECT_TRUE(rows[0].vectors.contains("T_object_measured_r_rad"));
  EXPECT_NEAR(rows[0].vectors.at("object_shift_mm").x(), -0.1, 0.01);
  EXPECT_EQ(rows[0].numbers.at("within_10um"), 1.0);
  EXPECT_FALSE(rows[1].usable);
  EXPECT_FALSE(rows[1].warning.empty());
  bench.twin.measure.fits = {{"nobody", 2.0}};
  EXPECT_THROW(fit_objects(bench.twin, cloud), UserError);
}

}  // namespace
}  // namespace fringetwin::measure::object_fits_test
