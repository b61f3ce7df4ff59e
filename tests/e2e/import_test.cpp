// SPDX-License-Identifier: Apache-2.0
// import opencv: what it writes is what the twin reads; what it cannot know is refused, with nothing written.
//
// | check                      | tolerance | unit | origin                                     |
// |----------------------------|-----------|------|--------------------------------------------|
// | translation, mm and m      | 1e-12     | mm   | one multiplication by 1000, one by 0.001   |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/small_twin.hpp"
#include "twin/twin.hpp"

namespace fringetwin::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kCalibration = R"(%YAML:1.0
---
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 600., 0., 31.5, 0., 600., 23.5, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 4
   dt: d
   data: [ -0.1, 0., 0., 0. ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -100., 1., 2. ]
)";

class Import : public ::testing::Test {
 protected:
  void SetUp() override {
    dir_ = scratch_folder("import");
    write_file(dir_ / "rig.yml", kCalibration);
  }
  RunResult import(std::vector<std::string> args) {
    args.insert(args.begin(),
                {"import", "opencv", (dir_ / "rig.yml").string(), "--out", (dir_ / "out").string()});
    return run_fringetwin(args);
  }
  void expect_nothing_written(std::vector<std::string> args, const std::vector<std::string>& parts) {
    expect_refused(import(std::move(args)), 2, parts);
    EXPECT_FALSE(fs::exists(dir_ / "out"));
  }
  fs::path dir_;
};

TEST_F(Import, ARigOfTwoCamerasAndAProjector) {
  for (const auto& [unit, scale] : {std::pair{"mm", 1.0}, std::pair{"m", 1000.0}}) {
    const RunResult run = import({"--camera", "left=M1,D1@64x48", "--camera", "right 2=M1,D1,R,T@64x48",
                                  "--projector", "M1,D1,R,T@64x48", "--unit", unit});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Twin twin = load_twin(dir_ / "out" / "twin.toml");
    ASSERT_EQ(twin.cameras.size(), 2u);
    EXPECT_EQ(twin.cameras[0].T_cam_world.translation_mm, Eigen::Vector3d(0, 0, 0));
    EXPECT_EQ(twin.cameras[1].name, "right 2");
    const Eigen::Vector3d t = scale * Eigen::Vector3d(-100, 1, 2);
    EXPECT_LT((twin.cameras[1].T_cam_world.translation_mm - t).norm(), 1e-12 * scale);
    EXPECT_LT((twin.projector->T_proj_world.translation_mm - t).norm(), 1e-12 * scale);
    EXPECT_EQ(twin.projector->lens.intrinsics().at(4), -0.1);
  }
}

// The identity would put both devices into one place, without a word.
TEST_F(Import, OnlyTheFirstCameraMayLeaveOutItsPlace) {
  expect_nothing_written({"--camera", "left=M1,D1@64x48", "--camera", "right=M1,D1@64x48"},
                         {"--camera right=M1,D1@64x48: has no ROTATION,TRANSLATION"});
  expect_nothing_written({"--camera", "left=M1,D1@64x48", "--projector", "M1,D1@64x48"},
                         {"--projector M1,D1@64x48: has no ROTATION,TRANSLATION"});
}

TEST_F(Import, TwoDevicesOfOneNameAreRefused) {
  expect_nothing_written({"--camera", "projector=M1,D1@64x48", "--projector", "M1,D1,R,T@64x48"},
                         {"projector.cameramodel would be written twice"});
  expect_nothing_written({"--camera", "a=M1,D1@64x48", "--camera", "a=M1,D1,R,T@64x48"},
                         {"a.cameramodel would be written twice"});
  expect_nothing_written(
      {"--camera", "a=M1,D1@64x48", "--camera", "b=M1,D1,R,T@64x48", "--camera", "c=M1,D1,R,T@64x48"},
      {"--camera: is given 3 times"});
}

TEST_F(Import, NamesSizesAndKeysThatCannotBe) {
  for (const char* name : {"a/b", ".x", "50%", "a\"b", ""})
    expect_nothing_written({"--camera", std::string(name) + "=M1,D1@64x48"},
                           {"the name", "use letters, digits"});
  for (const char* size : {"64x48garbage", "64", "64y48", "x48"})
    expect_nothing_written({"--camera", std::string("left=M1,D1@") + size},
                           {"the image size cannot be read"});
  expect_nothing_written({"--camera", "left=M1@64x48"}, {"has 1 keys instead of 2 or 4"});
  expect_nothing_written({"--camera", "left=M1,D1@100000x100000"}, {"left: imagersize must be at most"});
  EXPECT_EQ(import({"--camera", "left=M9,D1@64x48"}).exit_code, 3);
  EXPECT_FALSE(fs::exists(dir_ / "out"));
}

}  // namespace
}  // namespace fringetwin::test
