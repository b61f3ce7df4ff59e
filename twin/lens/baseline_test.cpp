// SPDX-License-Identifier: Apache-2.0
// | check | tolerance | unit | origin |
// |---|---|---|---|
// | lengths and points | 1e-9 | mm | 1e-16 of 1e3 mm, 1e3 times more where axes are a few degrees apart |
// | angles, rotations | 1e-12 | rad | 1e3 roundings |
#include "twin/lens/baseline.hpp"

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include "twin/base/errors.hpp"
#include "twin/lens/look_at.hpp"
#include "twin/twin.hpp"

namespace fringetwin::baseline_test {
namespace {

using Eigen::Vector3d;
constexpr double mm = 1e-9, rad = 1e-12, deg = std::numbers::pi / 180.0;

/// Poses of two devices that look at points near one another, and the first pose of the world.
struct Pair {
  Pose first, device;
};
Pair random_pair(std::mt19937& random) {
  std::uniform_real_distribution<double> near(-40.0, 40.0), angle(-3.0, 3.0);
  const auto point = [&](double z) { return Vector3d(near(random), near(random), z + near(random)); };
  Pair pair{*look_at_pose(point(0), point(400), {0.1, -1, 0}),
            *look_at_pose(Vector3d(150, 0, 0) + point(0), point(400), {-0.3, -1, 0})};
  const Pose T_world_other =
      pose_from_rt((RotTrans() << angle(random), angle(random), angle(random), 10, 20, 30).finished());
  return {pair.first * T_world_other, pair.device * T_world_other};
}

Vector3d center(const Pose& T) { return T.inverse().translation_mm; }

// By hand: a device 100 mm to the right that looks at a point 250 mm before the first camera.
TEST(Baseline, IsTheDistanceAndTheAngleThatOfTheSights) {
  const Pose first, device = *look_at_pose({100, 0, 0}, {0, 0, 250});
  EXPECT_NEAR(baseline_mm(first, device), 100.0, mm);
  ASSERT_TRUE(aim_mm(first, device));
  EXPECT_LT((*aim_mm(first, device) - Vector3d(0, 0, 250)).norm(), mm);
  EXPECT_NEAR(triangulation_rad(first, device).value(), std::atan2(100.0, 250.0), rad);
}

TEST(Baseline, MovesAlongTheLineAndAimsAtTheSamePoint) {
  const Pose first, device = *look_at_pose({100, 0, 0}, {0, 0, 250});
  const auto moved = with_baseline(first, device, 160.0);
  ASSERT_TRUE(moved);
  const Pose expected = *look_at_pose({160, 0, 0}, {0, 0, 250});
  EXPECT_TRUE(moved->rotation.isApprox(expected.rotation, rad));
  EXPECT_LT((moved->translation_mm - expected.translation_mm).norm(), mm);
}

TEST(Baseline, AnAngleIsATurnAboutThePointAtTheSameDistance) {
  const Pose first, device = *look_at_pose({100, 0, 0}, {0, 0, 250});
  const auto moved = with_triangulation(first, device, 30.0 * deg);
  ASSERT_TRUE(moved);
  const double away = std::hypot(100.0, 250.0);
  const Pose expected =
      *look_at_pose({away * std::sin(30 * deg), 0, 250 - away * std::cos(30 * deg)}, {0, 0, 250});
  EXPECT_TRUE(moved->rotation.isApprox(expected.rotation, rad));
  EXPECT_LT((moved->translation_mm - expected.translation_mm).norm(), mm);
}

// Of poses at random: what was asked for is there, the rest stays, and the same number changes nothing.
TEST(Baseline, OfAnyPairIsWhatWasAskedFor) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    const auto [first, device] = random_pair(random);
    const Vector3d aim = aim_mm(first, device).value(), from = center(device);
    EXPECT_LT(std::abs((device * aim).x()) + std::abs((device * aim).y()), mm);
    for (const double asked : {40.0, baseline_mm(first, device), 300.0}) {
      const Pose moved = with_baseline(first, device, asked).value();
      EXPECT_NEAR(baseline_mm(first, moved), asked, mm);
      EXPECT_LT(((center(moved) - center(first)).normalized() - (from - center(first)).normalized()).norm(),
                rad);
      EXPECT_LT((moved * aim - Vector3d(0, 0, (aim - center(moved)).norm())).norm(), mm)
          << "still in the middle";
      EXPECT_NEAR(moved.rotation.determinant(), 1.0, rad);
    }
    const double before = triangulation_rad(first, device).value();
    for (const double asked : {3.0 * deg, before, 70.0 * deg}) {
      const Pose moved = with_triangulation(first, device, asked).value();
      const Vector3d to_first = (center(first) - aim).normalized(),
                     to_device = (center(moved) - aim).normalized();
      EXPECT_NEAR(std::atan2(to_first.cross(to_device).norm(), to_first.dot(to_device)), asked, rad);
      EXPECT_LT((moved * aim - Vector3d(0, 0, (aim - from).norm())).norm(), mm);
    }
    const Pose same =
        with_triangulation(first, with_baseline(first, device, baseline_mm(first, device)).value(), before)
            .value();
    EXPECT_TRUE(same.rotation.isApprox(device.rotation, 1e-10));
    EXPECT_LT((same.translation_mm - device.translation_mm).norm(), 1e-7);
  }
}

// Parallel axes aim at nothing: such a device is moved without a turn, and has no angle.
TEST(Baseline, OfParallelAxesIsAShift) {
  const Pose first;
  Pose device;
  device.translation_mm = Vector3d(-100, 0, 0);
  EXPECT_FALSE(aim_mm(first, device));
  EXPECT_FALSE(triangulation_rad(first, device));
  EXPECT_FALSE(with_triangulation(first, device, 0.3));
  const Pose moved = with_baseline(first, device, 130.0).value();
  EXPECT_EQ(moved.rotation, device.rotation);
  EXPECT_LT((moved.translation_mm - Vector3d(-130, 0, 0)).norm(), mm);
}

TEST(Baseline, IsRefusedWhereItSaysNothing) {
  const Pose first;
  EXPECT_FALSE(with_baseline(first, first, 100.0)) << "in which direction";
  EXPECT_FALSE(aim_mm(first, *look_at_pose({100, 0, 0}, {250, 0, 250}))) << "the axes meet behind it";
  // on the first camera's axis: no plane to turn in
  EXPECT_FALSE(with_triangulation(first, *look_at_pose({0, 0, -100}, {0, 0, 250}), 0.3));
  // straight to the point that it aims at
  EXPECT_FALSE(with_baseline(first, *look_at_pose({0, 100, 0}, {0, 0, 0}, {0, 0, 1}), 1e-4));
}

std::filesystem::path twin_with(const std::string& of_camera, const std::string& of_projector) {
  const auto file = std::filesystem::temp_directory_path() / "fringetwin_baseline.toml";
  const std::string lens =
      "lensmodel = \"LENSMODEL_PINHOLE\"\nimagersize = [64, 48]\nintrinsics = [80, 80, 31.5, 23.5]\n";
  std::ofstream(file) << "schema = \"fringetwin-twin/1\"\n[[camera]]\nname = \"left\"\n"
                      << lens << of_camera << "[projector]\n"
                      << lens << of_projector
                      << "[fringes]\ndirections = [\"x\"]\npitches_px = [13]\nsteps = 4\n"
                      << "unwrap = \"none\"\n";
  return file;
}

std::string refusal(const std::string& of_camera, const std::string& of_projector) {
  try {
    (void)load_twin(twin_with(of_camera, of_projector));
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

const std::string kPose = "position_mm = [100, 0, 0]\nlook_at_mm = [0, 0, 250]\n";

TEST(Baseline, OfATwinIsSetWhateverItsPoseCameFrom) {
  const Twin stated = load_twin(twin_with("", kPose));
  for (const std::string& pose :
       {kPose, fmt::format("rt_cam_world = [{}]\n",
                           fmt::join(rt_from_pose(stated.projector->T_proj_world), ", "))}) {
    const Twin near = load_twin(twin_with("", pose + "baseline_mm = 80\n"));
    EXPECT_NEAR(baseline_mm(near.cameras[0].T_cam_world, near.projector->T_proj_world), 80.0, mm);
    // as a study sets it
    const Twin steep = load_twin(twin_with("", pose), {{"projector.angle_deg", "40"}});
    EXPECT_NEAR(triangulation_rad(steep.cameras[0].T_cam_world, steep.projector->T_proj_world).value(),
                40 * deg, rad);
  }
}

TEST(Baseline, OfATwinIsRefusedWithASentence) {
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal("baseline_mm = 100\n", kPose), HasSubstr("this is that"));
  EXPECT_THAT(refusal("", kPose + "baseline_mm = 90\nangle_deg = 20\n"), HasSubstr("is given beside"));
  EXPECT_THAT(refusal("", kPose + "baseline_mm = 0\n"), HasSubstr("baseline_mm"));
  EXPECT_THAT(refusal("", "rt_cam_world = [0, 0, 0, 0, 0, 0]\nbaseline_mm = 90\n"),
              HasSubstr("at one place"));
  EXPECT_THAT(refusal("", "rt_cam_world = [0, 0, 0, -90, 0, 0]\nangle_deg = 20\n"), HasSubstr("parallel"));
}

}  // namespace
}  // namespace fringetwin::baseline_test
