// SPDX-License-Identifier: Apache-2.0
// Tolerances
//   2e-5 mm    registration of points that lie exactly on the mesh: Gauss-Newton converges to 1e-7 mm, float
//              vertices round at 5e-7 mm; the median weights of creases leave the rest
//   3 sigma/sqrt(n)  with noise
//   0.7...1.3  rms of errors over their sigma, 24 draws of 6 independent numbers: 5 times 1/sqrt(288);
//   0.5...1.5  the same where 60 blocks tell sigma, to a tenth and rather too large
//   none       on time: printed, for the benchmark to judge
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>

#include "measure/fit/fits.hpp"
#include "measure/fit/shape_fits.hpp"
#include "tests/support/measure/test_meshes.hpp"
#include "twin/twin.hpp"

namespace fringetwin::measure::register_mesh_test {
namespace {

using namespace testing;

Pose small_pose(double degrees, double mm, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> n;
  RotTrans rt;
  rt.head<3>() = Eigen::Vector3d(n(random), n(random), n(random)).normalized() * degrees * M_PI / 180;
  rt.tail<3>() = Eigen::Vector3d(n(random), n(random), n(random)).normalized() * mm;
  return pose_from_rt(rt);
}

/// Points on the side that faces -z, in the world frame.
std::vector<Eigen::Vector3d> seen_points(const MeshShape& cad, std::size_t n, double noise_mm,
                                         unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> p;
  while (p.size() < n) {
    const auto& t = cad.mesh->triangles[random() % cad.mesh->triangles.size()];
    const Eigen::Vector3d a = cad.mesh->vertices_mm[t[0]].cast<double>(),
                          b = cad.mesh->vertices_mm[t[1]].cast<double>(),
                          c = cad.mesh->vertices_mm[t[2]].cast<double>();
    const Eigen::Vector3d normal_object = (b - a).cross(c - a).normalized();
    if ((cad.T_world_object.rotation * normal_object).z() > -0.3) continue;
    const double root = std::sqrt(uniform(random)), v = uniform(random);
    p.push_back(cad.T_world_object * ((1 - root) * a + root * (1 - v) * b + root * v * c +
                                      noise_mm * normal(random) * normal_object));
  }
  return p;
}

/// How far the two poses carry the points apart.
double pose_error_mm(const Pose& a, const Pose& b, const std::vector<Eigen::Vector3d>& p) {
  double largest = 0.0;
  for (std::size_t i = 0; i < p.size(); i += 97) largest = std::max(largest, (a * p[i] - b * p[i]).norm());
  return largest;
}

MeshShape freeform(int n) {
  MeshShape cad;
  cad.mesh = std::make_shared<const Mesh>(bumpy_sphere(25.0, n));
  cad.T_world_object = pose_from_rt((RotTrans() << 0.3, -0.2, 0.1, 5, -3, 260).finished());
  return cad;
}

TEST(RegisterMesh, FindsTheOffsetOfAFreeFormPart) {
  const MeshShape cad = freeform(80);
  const auto on_surface = seen_points(cad, 20000, 0.0, 1);
  struct Case {
    double degrees, mm, gate_mm;
  };
  for (const Case& c : {Case{0, 0, 2}, Case{1, 2, 5}, Case{3, 1, 5}, Case{0.01, 0.005, 2}}) {
    const Pose T_moved_true = small_pose(c.degrees, c.mm, 7);
    // turned about the part, not about the far origin
    const Eigen::Vector3d center = cad.T_world_object.translation_mm;
    const Pose T =
        Pose{Eigen::Matrix3d::Identity(), center} * T_moved_true * Pose{Eigen::Matrix3d::Identity(), -center};
    std::vector<Eigen::Vector3d> moved;
    for (const auto& p : on_surface) moved.push_back(T * p);
    const MeshFit fit = register_mesh(moved, cad, c.gate_mm);
    ASSERT_TRUE(fit.usable) << fit.message;
    const double error = pose_error_mm(fit.T_object_measured, T.inverse(), moved);
    std::printf("%.2f deg %.3f mm: pose off by %.1e mm, rms %.1e mm\n", c.degrees, c.mm, error, fit.rms_mm);
    EXPECT_LT(error, 2e-5);
    EXPECT_LT(fit.rms_mm, 2e-5);
    EXPECT_EQ(fit.n, moved.size());
    EXPECT_EQ(fit.within_10um, 1.0);
  }
}

TEST(RegisterMesh, NoiseAndOutliersGiveTheNoise) {
  const MeshShape cad = freeform(80);
  const double noise = 0.01;
  auto points = seen_points(cad, 40000, noise, 2);
  const std::size_t good = points.size();
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(0.1, 1.5);
  for (int k = 0; k < 6000; ++k)
    points.push_back(points[random() % good] - u(random) * Eigen::Vector3d::UnitZ());
  const Pose T = small_pose(0.02, 0.1, 8);
  for (auto& p : points) p = T * p;
  const MeshFit fit = register_mesh(points, cad, 2.0);
  ASSERT_TRUE(fit.usable) << fit.message;
  EXPECT_LT(pose_error_mm(fit.T_object_measured, T.inverse(), points), 0.003);
  double sum = 0.0;
  std::size_t n = 0;
  for (std::size_t k = 0; k < fit.index.size() && fit.index[k] < good; ++k, ++n)
    sum += std::pow(static_cast<double>(fit.deviation_mm[k]), 2);
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(n)), noise, 0.05 * noise);
  EXPECT_GT(fit.rms_mm, 5 * noise);  // outliers within the gate are not hidden
}

TEST(RegisterMesh, SlidingDirectionsAreLeftAlone) {
  // a plane of two triangles: the distance to vertices would be tens of mm, and it may slide and turn in
  // itself
  MeshShape cad;
  cad.mesh = std::make_shared<const Mesh>(square(100.0f));
  cad.T_world_object = pose_from_rt((RotTrans() << M_PI, 0, 0, 0, 0, 260).finished());
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 5000; ++i) points.push_back({-20 + 0.4 * (i % 100), -20 + 0.8 * (i / 100), 260.5});
  const MeshFit fit = register_mesh(points, cad, 2.0);
  ASSERT_TRUE(fit.usable) << fit.message;
  EXPECT_LT(fit.rms_mm, 1e-6);
  EXPECT_NEAR((fit.T_object_measured * points[0]).z(), 260.0, 1e-6);
  // it did not slide
  EXPECT_LT((fit.T_object_measured * points[2550] - points[2550]).head<2>().norm(), 0.5);
}

/// Points of a part at its place with errors of their own and, in blocks of 6 mm, errors that they share.
Gated noisy_points(const MeshShape& cad, double noise_mm, double shared_mm, unsigned seed) {
  std::mt19937_64 random(seed + 1000);
  std::normal_distribution<double> normal;
  std::map<int, double> shared;
  Gated out;
  out.gate_mm = 2.0;
  for (const Eigen::Vector3d& p : seen_points(cad, 3000, noise_mm, seed)) {
    const int block = 100 * static_cast<int>(p.x() / 6 + 50) + static_cast<int>(p.y() / 6 + 50);
    const double error = shared.try_emplace(block, shared_mm * normal(random)).first->second;
    out.p_mm.push_back(p + error * (p - cad.T_world_object.translation_mm).normalized());
    if (shared_mm > 0.0) out.block.push_back(block);
  }
  return out;
}

TEST(RegisterMesh, StandardErrorsHoldTheErrors) {
  const MeshShape cad = freeform(40);
  for (const double shared_mm : {0.0, 0.005}) {
    double sum = 0.0;
    int n = 0;
    for (unsigned draw = 0; draw < 24; ++draw) {
      ObjectFit row;
      fit_shape(cad, noisy_points(cad, 0.01, shared_mm, draw), row);
      ASSERT_TRUE(row.usable) << row.warning;
      // the part lies where the twin has it: the truth of all is 0
      for (const auto& [key, sigma] : {std::pair{"T_object_measured_r_rad", "T_object_measured_r_sigma_rad"},
                                       std::pair{"T_object_measured_t_mm", "T_object_measured_t_sigma_mm"},
                                       std::pair{"object_turn_rad", "object_turn_sigma_rad"},
                                       std::pair{"object_shift_mm", "object_shift_sigma_mm"}}) {
        sum += row.vectors.at(key).cwiseQuotient(row.vectors.at(sigma)).squaredNorm();
        n += 3;
      }
    }
    const double rms = std::sqrt(sum / n);
    std::printf("errors over their sigma, %.3f mm shared by neighbours: rms %.2f\n", shared_mm, rms);
    EXPECT_GT(rms, shared_mm > 0.0 ? 0.5 : 0.7);
    EXPECT_LT(rms, shared_mm > 0.0 ? 1.5 : 1.3);
  }
}

TEST(RegisterMesh, SlidingDirectionsHaveNoStandardError) {
  MeshShape cad;
  cad.mesh = std::make_shared<const Mesh>(square(100.0f));
  cad.T_world_object = pose_from_rt((RotTrans() << M_PI, 0, 0, 0, 0, 260).finished());
  std::mt19937_64 random(6);
  std::normal_distribution<double> noise(0.0, 0.01);
  Gated points;
  points.gate_mm = 2.0;
  for (int i = 0; i < 5000; ++i)
    points.p_mm.push_back({-20 + 0.4 * (i % 100), -20 + 0.8 * (i / 100), 260 + noise(random)});
  ObjectFit row;
  fit_shape(cad, points, row);
  ASSERT_TRUE(row.usable) << row.warning;
  const Eigen::Vector3d shift = row.vectors.at("object_shift_sigma_mm"),
                        turn = row.vectors.at("object_turn_sigma_rad");
  EXPECT_TRUE(std::isnan(shift.x()) && std::isnan(shift.y()) && std::isnan(turn.z()));
  // Tukey's weights have 95 % efficiency; 5000 points tell a scatter to 1 %, its sandwich to 2 %
  const double of_mean = 0.01 / std::sqrt(5000 * 0.95);
  EXPECT_NEAR(shift.z(), of_mean, 0.06 * of_mean);
  EXPECT_NEAR(turn.x(), of_mean / 11.5, 0.06 * of_mean / 11.5);  // 40 mm over the root of 12
  EXPECT_NEAR(turn.y(), of_mean / 11.5, 0.06 * of_mean / 11.5);
}

TEST(RegisterMesh, SignTellsTheSide) {
  MeshShape cad;
  cad.mesh = std::make_shared<const Mesh>(square(100.0f));  // normal +z
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 2500; ++i) points.push_back({-20 + 0.8 * (i % 50), -20 + 0.8 * (i / 50), 0});
  points[100].z() = 0.3;   // a pimple, outside
  points[700].z() = -0.3;  // a dent
  const MeshFit fit = register_mesh(points, cad, 2.0);
  ASSERT_TRUE(fit.usable);
  EXPECT_NEAR(static_cast<double>(fit.deviation_mm[100]), 0.3, 1e-6);
  EXPECT_NEAR(static_cast<double>(fit.deviation_mm[700]), -0.3, 1e-6);
}

TEST(RegisterMesh, TooLittleIsSaid) {
  const MeshShape cad = freeform(20);
  EXPECT_FALSE(register_mesh({}, cad, 2.0).usable);
  EXPECT_FALSE(register_mesh({5, {0, 0, 250}}, cad, 2.0).usable);
  EXPECT_FALSE(
      register_mesh(std::vector<Eigen::Vector3d>(100, {500, 0, 0}), cad, 2.0).usable);  // all beyond the gate
  EXPECT_FALSE(register_mesh(std::vector<Eigen::Vector3d>(100, {NAN, 0, 0}), cad, 2.0).usable);
}

TEST(RegisterMesh, StepsThatRunOutAreNoResult) {
  const MeshShape cad = freeform(80);
  auto points = seen_points(cad, 20000, 0.002, 4);
  const Pose T = small_pose(1, 2, 9);
  for (auto& p : points) p = T * p;
  EXPECT_TRUE(register_mesh(points, cad, 5.0).usable);
  const MeshFit stopped = register_mesh(points, cad, 5.0, {}, 1);
  EXPECT_FALSE(stopped.usable);
  EXPECT_NE(stopped.message.find("did not settle"), std::string::npos) << stopped.message;
  EXPECT_GT(stopped.n, 20u);  // enough points: exit code 5, not "too few"
}

// Point to point slides along the surface in ever smaller steps; point to plane comes to where the samples of
// the surface say. 3 um: 5000 points of 2 um against samples that end facets roughly (measured: 1.0 um).
TEST(RegisterMesh, PointToPlaneLeavesLittleToTheLastSteps) {
  const MeshShape cad = freeform(40);
  auto points = seen_points(cad, 5000, 0.002, 4);
  const Eigen::Vector3d center = cad.T_world_object.translation_mm;
  const Pose T = Pose{Eigen::Matrix3d::Identity(), center} * small_pose(5, 4, 9) *
                 Pose{Eigen::Matrix3d::Identity(), -center};
  for (auto& p : points) p = T * p;
  const MeshFit without_last_steps = register_mesh(points, cad, 5.0, {}, 0);
  EXPECT_LT(pose_error_mm(without_last_steps.T_object_measured, T.inverse(), points), 0.003);
  EXPECT_TRUE(register_mesh(points, cad, 5.0, {}, 3).usable);
}

TEST(RegisterMesh, ManyPoints) {
  const MeshShape cad = freeform(144);  // 82,368 triangles
  const auto points = seen_points(cad, 150000, 0.003, 3);
  const auto start = std::chrono::steady_clock::now();
  const MeshFit fit = register_mesh(points, cad, 2.0);
  const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%zu triangles, 150k points: %.2f s, rms %.4f mm\n", cad.mesh->triangles.size(), s, fit.rms_mm);
  ASSERT_TRUE(fit.usable) << fit.message;
  EXPECT_NEAR(fit.rms_mm, 0.003, 0.0001);
}

}  // namespace
}  // namespace fringetwin::measure::register_mesh_test
