// SPDX-License-Identifier: Apache-2.0
// import: what it writes is what the twin reads; what it cannot know is refused, with nothing written.
//
// | check                      | tolerance | unit | origin                                     |
// |----------------------------|-----------|------|--------------------------------------------|
// | translation, mm and m      | 1e-12     | mm   | one multiplication by 1000, one by 0.001   |
// | brightness                 | 1         | DN   | intensity is written with two digits       |
// | chained, inverted          | 1e-9      | mm   | products of numbers of 1e2, typed in       |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/program/small_twin.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::import_test {
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
    // Paper (diffuse 0.8) that faces both in white: about 80 % of full scale, and read as it is written.
    EXPECT_NEAR(twin.cameras[0].sensor.gain_dn * twin.projector->intensity * 0.8 / std::numbers::pi,
                0.8 * 255, 1.0);
  }
}

// OpenCV's sample writes a file per camera, all with the same names.
TEST_F(Import, OneFilePerCamera) {
  std::string other = kCalibration;
  other.replace(other.find("600."), 4, "700.");
  other.insert(other.find("M1:"), "image_width: 48\nimage_height: 64\n");
  write_file(dir_ / "other.yml", other);
  const std::string file = (dir_ / "other.yml").string();
  const RunResult refused = import({file, "--camera", "left=M1,D1@64x48"});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err,
              HasSubstr("rig.yml, " + file + ": each of them has a matrix 'M1'; say which is meant"));
  EXPECT_FALSE(fs::exists(dir_ / "out"));
  const RunResult run = import({file, "--camera", "left=rig.yml:M1,none@64x48", "--camera",
                                "right=other.yml:M1,other.yml:D1,rig.yml:R,rig.yml:T@64x48"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("right: " + file +
                                 " says that the images are 48x64 (image_width, "
                                 "image_height), not 64x48"));
  const Twin twin = load_twin(dir_ / "out" / "twin.toml");
  EXPECT_EQ(twin.cameras.at(0).lens.model(), "LENSMODEL_PINHOLE");
  EXPECT_EQ(twin.cameras.at(0).lens.intrinsics().at(0), 600.0);
  EXPECT_EQ(twin.cameras.at(1).lens.intrinsics().at(0), 700.0);
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
  expect_nothing_written({"--camera", "left=M1,D1@100000x100000"}, {"M1: imagersize must be at most"});
  EXPECT_EQ(import({"--camera", "left=M9,D1@64x48"}).exit_code, 3);
  EXPECT_FALSE(fs::exists(dir_ / "out"));
}

TEST_F(Import, SwappedSidesAreDoubted) {
  const RunResult swapped = import({"--camera", "left=M1,D1@48x64"});
  EXPECT_EQ(swapped.exit_code, 0) << swapped.err;
  EXPECT_THAT(swapped.err,
              HasSubstr("left: the principal point (31.5, 23.5) px lies in the middle of 64x48, not of "
                        "48x64: are width and height swapped?"));
  // as it is, square, and a projector whose image lies above its axis
  for (const char* size : {"64x48", "64x64", "64x32", "64x24"})
    EXPECT_THAT(import({"--camera", std::string("left=M1,D1@") + size}).err,
                ::testing::Not(HasSubstr("swapped")))
        << size;
}

// Plain matrices whose R, T map the other way: --check says so, nothing is written; with --poses they come
// in.
TEST_F(Import, CheckTellsInvertedPoses) {
  write_file(dir_ / "K.txt", "600 0 319.5\n0 600 239.5\n0 0 1\n");
  write_file(dir_ / "RT.txt", "0.8 0 0.6 -150\n0 1 0 2\n-0.6 0 0.8 60\n");  // x_right = R x_left + T
  std::string backward, seen = "u_left v_left u_right v_right\n";
  backward = "0.8 0 -0.6 156\n0 1 0 -2\n0.6 0 0.8 42\n";  // its inverse, by hand
  write_file(dir_ / "TR.txt", backward);
  for (int i = 0; i < 20; ++i) {
    const double x = 20.0 * (i % 5) - 10.0, y = 15.0 * (i / 5) - 20.0, z = 300.0 + 3.0 * i;
    const double xr = 0.8 * x + 0.6 * z - 150.0, yr = y + 2.0, zr = -0.6 * x + 0.8 * z + 60.0;
    for (const double v :
         {319.5 + 600 * x / z, 239.5 + 600 * y / z, 319.5 + 600 * xr / zr, 239.5 + 600 * yr / zr})
      seen += std::to_string(v) + " ";
    seen += "\n";
  }
  write_file(dir_ / "seen.txt", seen);
  const auto k = (dir_ / "K.txt").string();
  const auto matrices = [&](const std::string& rt, std::vector<std::string> more) {
    std::vector<std::string> args{"import",   "matrices",
                                  "--camera", "left=" + k + ",none@640x480",
                                  "--camera", "right=" + k + ",none," + (dir_ / rt).string() + "@640x480",
                                  "--out",    (dir_ / "out").string()};
    args.insert(args.end(), more.begin(), more.end());
    return run_fringetwin(args);
  };
  const std::string observations = (dir_ / "seen.txt").string();
  const RunResult wrong = matrices("TR.txt", {"--check", observations});
  expect_refused(
      wrong, 3,
      {"seen.txt: right: R, T fit the observations inverted", "import with --poses ref-from-device"});
  EXPECT_THAT(wrong.out, HasSubstr("right: R, T as given: "));
  EXPECT_FALSE(fs::exists(dir_ / "out"));
  for (const auto& [file, poses] :
       {std::pair{"RT.txt", "device-from-ref"}, std::pair{"TR.txt", "ref-from-device"}}) {
    const RunResult right = matrices(file, {"--check", observations, "--poses", poses});
    ASSERT_EQ(right.exit_code, 0) << right.err;
    const Twin twin = load_twin(dir_ / "out" / "twin.toml");
    EXPECT_LT((twin.cameras[1].T_cam_world.translation_mm - Eigen::Vector3d(-150, 2, 60)).norm(), 1e-9);
  }
}

TEST_F(Import, KalibrAndMrcal) {
  const std::string camera =
      "  camera_model: pinhole\n  intrinsics: [600, 600, 319.5, 239.5]\n  distortion_model: radtan\n"
      "  distortion_coeffs: [-0.1, 0, 0, 0]\n  resolution: [640, 480]\n";
  const std::string place = "  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0.02], [0, 0, 0, 1]]\n";
  write_file(dir_ / "chain.yaml",
             "cam0:\n" + camera + "cam1:\n" + camera + place + "cam2:\n" + camera + place);
  const std::string out = (dir_ / "out").string();
  const auto import_chain = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"import", "kalibr", (dir_ / "chain.yaml").string(), "--out", out});
    return run_fringetwin(more);
  };
  expect_refused(import_chain({}), 2, {"chain.yaml: has 3 cameras; a twin has one camera or two"});
  expect_refused(import_chain({"--projector", "cam7"}), 2, {"the camchain has no such camera"});
  EXPECT_FALSE(fs::exists(out));
  const RunResult run = import_chain({"--projector", "cam1", "--names", "left,right"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Twin twin = load_twin(dir_ / "out" / "twin.toml");
  EXPECT_EQ(twin.cameras[1].name, "right");
  EXPECT_LT((twin.cameras[1].T_cam_world.translation_mm - Eigen::Vector3d(-200, 0, 40)).norm(), 1e-9);
  EXPECT_LT((twin.projector->T_proj_world.translation_mm - Eigen::Vector3d(-100, 0, 20)).norm(), 1e-9);

  const auto model = [&](const char* name) { return (dir_ / "out" / name).string(); };
  const RunResult again =
      run_fringetwin({"import", "mrcal", model("left.cameramodel"), model("right.cameramodel"), "--projector",
                      model("projector.cameramodel"), "--out", (dir_ / "again").string()});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Twin same = load_twin(dir_ / "again" / "twin.toml");
  EXPECT_EQ(same.cameras[1].lens.intrinsics(), twin.cameras[1].lens.intrinsics());
  EXPECT_LT(
      (same.projector->T_proj_world.translation_mm - twin.projector->T_proj_world.translation_mm).norm(),
      1e-12);
}

}  // namespace
}  // namespace fringetwin::testing::import_test
