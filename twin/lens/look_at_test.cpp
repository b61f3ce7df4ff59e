// SPDX-License-Identifier: Apache-2.0
// | check | tolerance | unit | origin |
// |---|---|---|---|
// | points and axes | 1e-12 | mm | 20 roundings of 2.2e-16 at 250 mm |
// | equal to rt_cam_world | 1e-9 | mm | the vector is written with 15 digits, and some are lost on the way to
// a matrix |
#include "twin/lens/look_at.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <fstream>

#include "twin/base/errors.hpp"
#include "twin/twin.hpp"

namespace fringetwin::look_at_test {
namespace {

constexpr double mm = 1e-12;

TEST(LookAt, AlongZFromTheOriginIsTheIdentity) {
  const auto pose = look_at_pose({0, 0, 0}, {0, 0, 250});
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->rotation, Eigen::Matrix3d::Identity());
  EXPECT_EQ(pose->translation_mm.norm(), 0.0);
}

TEST(LookAt, TheTargetIsOnTheAxisAndUpIsUp) {
  const Eigen::Vector3d position(100, -30, 20), target(5, 7, 250), up(0.2, -1, 0.1);
  const auto pose = look_at_pose(position, target, up);
  ASSERT_TRUE(pose);
  EXPECT_LT((*pose * position).norm(), mm);
  EXPECT_LT((*pose * target - Eigen::Vector3d(0, 0, (target - position).norm())).norm(), mm);
  EXPECT_NEAR(pose->rotation.determinant(), 1.0, mm);
  EXPECT_TRUE((pose->rotation * pose->rotation.transpose()).isIdentity(mm));
  const Eigen::Vector3d shown = pose->rotation * up;
  EXPECT_NEAR(shown.x(), 0.0, mm);  // not to the side
  EXPECT_LT(shown.y(), -0.5);       // y of an image points down
}

// By hand: the axis to the right of the image stays level, so that a device 100 mm to the right turns about y
// alone, by atan(100/250) to the left.
TEST(LookAt, ADeviceBesideTheOriginTurnsAboutY) {
  const auto pose = look_at_pose({100, 0, 0}, {0, 0, 250});
  ASSERT_TRUE(pose);
  const Eigen::Vector3d r = vector_from_rotation(pose->rotation);
  EXPECT_LT((r - Eigen::Vector3d(0, std::atan2(100.0, 250.0), 0)).norm(), mm);
  const double axis = std::hypot(100.0, 250.0);
  EXPECT_LT(
      (*pose * Eigen::Vector3d(0, 0, 0) - Eigen::Vector3d(-100.0 * 250.0, 0, 100.0 * 100.0) / axis).norm(),
      mm);
}

TEST(LookAt, NoDirectionIsNoPose) {
  EXPECT_FALSE(look_at_pose({1, 2, 3}, {1, 2, 3}));
  EXPECT_FALSE(look_at_pose({0, -300, 0}, {0, 0, 0}));  // along up
  EXPECT_TRUE(look_at_pose({0, -300, 0}, {0, 0, 0}, {0, 0, 1}));
  EXPECT_FALSE(look_at_pose({0, 0, 0}, {0, 0, 1}, {0, 0, 0}));
}

std::filesystem::path twin_with(const std::string& pose) {
  const auto file = std::filesystem::temp_directory_path() / "fringetwin_look_at.toml";
  std::ofstream(file) << "schema = \"fringetwin-twin/1\"\n[[camera]]\nname = \"left\"\n"
                         "lensmodel = \"LENSMODEL_PINHOLE\"\nimagersize = [64, 48]\n"
                         "intrinsics = [80, 80, 31.5, 23.5]\n[projector]\nlensmodel = "
                         "\"LENSMODEL_PINHOLE\"\nimagersize = [64, 48]\nintrinsics = [80, 80, 31.5, 23.5]\n"
                      << pose << "[fringes]\ndirections = [\"x\"]\npitches_px = [13]\nsteps = 4\n"
                      << "unwrap = \"none\"\n";
  return file;
}

std::string refusal(const std::string& pose) {
  try {
    (void)load_twin(twin_with(pose));
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

TEST(LookAt, ATwinReadsItAsItReadsTheVector) {
  const Twin looked = load_twin(twin_with("position_mm = [100, 0, 0]\nlook_at_mm = [0, 0, 250]\n"));
  const Twin vector =
      load_twin(twin_with("rt_cam_world = [0, 0.380506377112365, 0, -92.8476690885259, 0, "
                          "37.1390676354104]\n"));
  EXPECT_LT(
      (looked.projector->T_proj_world.translation_mm - vector.projector->T_proj_world.translation_mm).norm(),
      1e-9);
  EXPECT_LT((looked.projector->T_proj_world.rotation - vector.projector->T_proj_world.rotation).norm(), 1e-9);
}

TEST(LookAt, ATwinRefusesWhatIsNoPose) {
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal("position_mm = [1, 2, 3]\n"), HasSubstr("look_at_mm"));
  EXPECT_THAT(refusal("look_at_mm = [1, 2, 3]\n"), HasSubstr("position_mm"));
  EXPECT_THAT(refusal("up = [0, 0, 1]\n"), HasSubstr("position_mm"));
  EXPECT_THAT(refusal("position_mm = [1, 2, 3]\nlook_at_mm = [1, 2, 3]\n"), HasSubstr("where it stands"));
  EXPECT_THAT(refusal("position_mm = [0, -300, 0]\nlook_at_mm = [0, 0, 0]\n"), HasSubstr("give up"));
  EXPECT_THAT(refusal("position_mm = [1, 2, 3]\nlook_at_mm = [0, 0, 9]\nrt_cam_world = [0, 0, 0, 0, 0, 0]\n"),
              HasSubstr("is given beside"));
}

}  // namespace
}  // namespace fringetwin::look_at_test
