// SPDX-License-Identifier: Apache-2.0
// Kalibr camchains and plain matrices as they are written elsewhere, and which way R, T fit what was seen.
//
// | check                             | tolerance | unit | origin                                        |
// |-----------------------------------|-----------|------|-----------------------------------------------|
// | numbers of the files              | 1e-12     |      | typed in                                      |
// | chain of three poses              | 1e-9      | mm   | product of the 4x4 matrices                   |
// | kamino: reprojection, all 5 views | 0.31      | px   | issue: joint reprojection of the set's CSV    |
// |   inverted poses told             | exact     |      | the calibration beside the CSV, inverted here |
// | drawn points, 0.2 px noise        | 0.18-0.31 | px   | drawn; distance from a line: one coordinate of|
// |                                   |           |      | each device, so between 1 and sqrt(2) of it   |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>

#include "calib/import/check_import.hpp"
#include "twin/base/errors.hpp"
#include "twin/image/image_io.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/pose_fault.hpp"
#include "twin/twin.hpp"

namespace fringetwin::calib::import_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class ImportFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::temp_directory_path() / ("fringetwin-import-" + std::to_string(::getpid()));
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }
  fs::path write(const std::string& name, const std::string& text) {
    write_text_file(dir_ / name, text);
    return dir_ / name;
  }
  fs::path dir_;
};

template <class Action>
std::string refusal(Action action) {
  try {
    action();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input) << e.what();
    return e.what();
  }
  return "not refused";
}

// As Kalibr prints it: keys sorted, block sequences of flow sequences, comments, an imu beside.
constexpr const char* kCamchain = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.074, 0.0002, 1.8e-05]
  distortion_model: radtan
  intrinsics: [458.5, 457.25, 367.0, 248.5]   # fu fv pu pv
  resolution: [752, 480]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: -1.2e-05
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 0.0, -1.0, 0.002]
  - [0.0, 1.0, 0.0,
     0.003]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: []
  distortion_model: none
  intrinsics: [460.0, 461.0, 379.0, 255.0]
  resolution: [752, 480]
cam2:
  T_cn_cnm1:
  - - 0.0
    - -1.0
    - 0.0
    - 0.05
  - - 1.0
    - 0.0
    - 0.0
    - -0.06
  - [0.0, 0.0, 1.0, 0.07]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [0.1, -0.2, 0.001, -0.002, 0.3]
  distortion_model: plumb_bob
  intrinsics: [1000, 1001, 511.5, 383.5]
  resolution: [1024, 768]
imu0:
  rate_hz: 200
)";

TEST_F(ImportFiles, KalibrCamchain) {
  const auto devices = import_kalibr(write("camchain.yaml", kCamchain));
  ASSERT_EQ(devices.size(), 3u);
  EXPECT_EQ(devices[0].name, "cam0");
  EXPECT_EQ(devices[0].lensmodel, "LENSMODEL_OPENCV4");
  EXPECT_EQ(devices[0].intrinsics,
            (std::vector<double>{458.5, 457.25, 367.0, 248.5, -0.28, 0.074, 0.0002, 1.8e-05}));
  EXPECT_EQ(devices[0].imagersize_px, (std::array<int, 2>{752, 480}));
  EXPECT_EQ(devices[1].lensmodel, "LENSMODEL_PINHOLE");
  EXPECT_EQ(devices[2].lensmodel, "LENSMODEL_OPENCV5");
  EXPECT_EQ(devices[2].intrinsics.back(), 0.3);
  const Eigen::Vector3d p(10.0, -20.0, 500.0);  // through both matrices by hand
  const Eigen::Vector3d in_1(p.x() - 110.0, -p.z() + 2.0, p.y() + 3.0);
  EXPECT_LT((devices[1].T_device_ref * p - in_1).norm(), 1e-9);
  const Eigen::Vector3d in_2(-in_1.y() + 50.0, in_1.x() - 60.0, in_1.z() + 70.0);
  EXPECT_LT((devices[2].T_device_ref * p - in_2).norm(), 1e-9);
}

TEST_F(ImportFiles, KalibrFaultsNameTheLine) {
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = kCamchain;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return refusal([&] { (void)import_kalibr(write("bad.yaml", text)); });
  };
  EXPECT_THAT(with("camera_model: pinhole", "camera_model: omni"),
              AllOf(HasSubstr("bad.yaml:3: cam0.camera_model"), HasSubstr("\"omni\" has no equal")));
  EXPECT_THAT(with("radtan", "equidistant"), HasSubstr("calibrate with Kalibr's pinhole-radtan"));
  EXPECT_THAT(with("[458.5, 457.25,", "[458.5,"), HasSubstr("cam0.intrinsics: has 3 numbers instead of 4"));
  EXPECT_THAT(with("458.5", "nan"), HasSubstr("\"nan\" is not a finite number"));
  EXPECT_THAT(with("0.0, -1.0, 0.002", "0.0, 1.0, 0.002"),
              HasSubstr("cam1.T_cn_cnm1: is no rotation: determinant -1"));
  EXPECT_THAT(with("  resolution: [752, 480]\n", ""), HasSubstr("bad.yaml:1: cam0 has no resolution"));
  EXPECT_THAT(with("  rostopic", "\trostopic"), HasSubstr("has a tab"));
  EXPECT_THAT(with("[752, 480]", "[752.5, 480]"), HasSubstr("752.5 is no image side"));
  EXPECT_THAT(refusal([&] { (void)import_kalibr(write("other.yaml", "a: 1\n")); }), HasSubstr("has no cam0"));
  EXPECT_THAT(refusal([&] { (void)import_kalibr(dir_ / "none.yaml"); }),
              HasSubstr("the camchain cannot be read"));
}

TEST_F(ImportFiles, KalibrFloods) {
  std::string lines = "cam0:\n", numbers;
  for (int i = 0; i < 20000; ++i) lines += "  k" + std::to_string(i) + ": 1\n", numbers += "1, ";
  EXPECT_THAT(refusal([&] { (void)import_kalibr(write("lines.yaml", lines)); }),
              HasSubstr("lines.yaml:10001: has more than 10000 lines"));
  EXPECT_THAT(refusal([&] {
                (void)import_kalibr(
                    write("n.yaml", "cam0:\n  camera_model: pinhole\n  intrinsics: [" + numbers + "]\n"));
              }),
              HasSubstr("n.yaml:3: cam0.intrinsics: has more than 4 numbers"));
  const std::string nested(100000, '[');
  EXPECT_THAT(refusal([&] {
                (void)import_kalibr(
                    write("deep.yaml", "cam0:\n  camera_model: pinhole\n  intrinsics: " + nested + "\n"));
              }),
              HasSubstr("has 0 numbers instead of 4"));
  const std::string word(100000, 'x');
  EXPECT_LT(refusal([&] { (void)import_kalibr(write("w.yaml", word + ":\n  camera_model: 1\n")); }).size(),
            500u);
  EXPECT_LT(refusal([&] {
              (void)import_kalibr(write("c.yaml", "cam" + word + ":\n  camera_model: " + word + "\n"));
            }).size(),
            500u);
}

TEST_F(ImportFiles, ANumberTooLargeForAPoseIsSeen) {
  std::string text = kCamchain;
  text.replace(text.find("-0.11]"), 5, "1e308");
  const auto devices = import_kalibr(write("far.yaml", text));
  EXPECT_EQ(devices[1].where, (dir_ / "far.yaml").string() + ":10: cam1");
  EXPECT_EQ(pose_fault(devices[0].T_device_ref), "");
  EXPECT_THAT(pose_fault(devices[1].T_device_ref), HasSubstr("above 1e9 mm"));
  const ImportedDevice turned = import_matrices({write("K.txt", "1200 0 640\n0 1201 512\n0 0 1\n"),
                                                 {},
                                                 write("r.txt", "1e300 0 0\n"),
                                                 write("T.txt", "1 2 3\n")},
                                                1.0);
  EXPECT_THAT(pose_fault(turned.T_device_ref), HasSubstr("above 1e9 mm"));
}

TEST_F(ImportFiles, PlainMatrices) {
  const fs::path K = write("K.txt", "# numpy\n1.2e+03 0.000000e+00 6.4e+02\n0 +1.201e+03 512\n0 0 1\n");
  const fs::path D = write("D.csv", "-0.1,0.02,0.001,-0.002,0.3\n");
  const fs::path R = write("R.txt", "[[0. -1. 0.]\n [1. 0. 0.]\n [0. 0. 1.]]\n");
  const fs::path T = write("T.txt", "-0.1\n0.02\n0.003\n");
  const ImportedDevice d = import_matrices({K, D, R, T}, 1000.0);
  EXPECT_EQ(d.lensmodel, "LENSMODEL_OPENCV5");
  EXPECT_EQ(d.intrinsics,
            (std::vector<double>{1200.0, 1201.0, 640.0, 512.0, -0.1, 0.02, 0.001, -0.002, 0.3}));
  EXPECT_LT((d.T_device_ref * Eigen::Vector3d(1.0, 2.0, 3.0) - Eigen::Vector3d(-102.0, 21.0, 6.0)).norm(),
            1e-12);
  const fs::path RT = write("RT.txt", "0 -1 0 -100\n1 0 0 20\n0 0 1 3\n0 0 0 1\n");
  const ImportedDevice same = import_matrices({K, {}, RT, {}}, 1.0);
  EXPECT_EQ(same.lensmodel, "LENSMODEL_PINHOLE");
  EXPECT_LT((same.T_device_ref.translation_mm - d.T_device_ref.translation_mm).norm(), 1e-12);
  const fs::path in_metres = write("RT_m.txt", "0 -1 0 -0.1\n1 0 0 0.02\n0 0 1 0.003\n");
  const ImportedDevice metres = import_matrices({K, {}, in_metres, {}}, 1000.0);
  EXPECT_LT((metres.T_device_ref.translation_mm - d.T_device_ref.translation_mm).norm(), 1e-12);
  const fs::path r = write("r.txt", "0 0 1.5707963267948966\n");
  EXPECT_LT((import_matrices({K, D, r, T}, 1.0).T_device_ref.rotation - d.T_device_ref.rotation).norm(),
            1e-12);
}

TEST_F(ImportFiles, MatrixFaultsNameTheFile) {
  const fs::path K = write("K.txt", "1200 0 640\n0 1201 512\n0 0 1\n"), T = write("T.txt", "1 2 3\n"),
                 R = write("R.txt", "1 0 0\n0 1 0\n0 0 1\n");
  const auto said = [&](const MatrixFiles& files) {
    return refusal([&] { (void)import_matrices(files, 1.0); });
  };
  EXPECT_THAT(said({write("t.txt", "1200 0 0\n0 1201 0\n640 512 1\n"), {}, {}, {}}),
              AllOf(HasSubstr("t.txt"), HasSubstr("it looks transposed")));
  EXPECT_THAT(said({write("s.txt", "1200 3 640\n0 1201 512\n0 0 1\n"), {}, {}, {}}), HasSubstr("has skew 3"));
  EXPECT_THAT(said({write("w.txt", "1200 0 640\n0 fy 512\n0 0 1\n"), {}, {}, {}}),
              HasSubstr("w.txt:2: \"fy\" is not a finite number"));
  EXPECT_THAT(said({write("j.txt", "1 2 3\n4 5\n"), {}, {}, {}}),
              HasSubstr("has 2 numbers, the rows above have 3"));
  EXPECT_THAT(said({write("e.txt", "# nothing\n"), {}, {}, {}}), HasSubstr("holds no numbers"));
  EXPECT_THAT(said({K, write("d.txt", "1 2 3\n"), {}, {}}), HasSubstr("has 3 distortion coefficients"));
  EXPECT_THAT(said({K, {}, write("m.txt", "1 0 0\n0 1 0\n0 0 -1\n"), T}),
              HasSubstr("is no rotation: determinant -1"));
  EXPECT_THAT(said({K, {}, R, {}}), HasSubstr("holds no translation"));
  EXPECT_THAT(said({K, {}, R, K}), HasSubstr("a translation has 3 numbers, this is 3x3"));
  EXPECT_THAT(said({dir_ / "none.txt", {}, {}, {}}), HasSubstr("the file of numbers cannot be read"));
  std::string row;
  for (int i = 0; i < 100000; ++i) row += "1 ";
  EXPECT_THAT(said({write("many.txt", row), {}, {}, {}}),
              HasSubstr("many.txt:1: holds more than 64 numbers"));
}

std::vector<ImportedDevice> drawn_rig() {
  std::vector<ImportedDevice> rig(3);
  rig[0] = {"left", "LENSMODEL_OPENCV4", {1700, 1700, 719.5, 539.5, -0.1, 0.1, 0, 0}, {1440, 1080}, Pose{},
            ""};
  rig[1] = rig[2] = rig[0];
  rig[1].name = "right";
  rig[1].T_device_ref = pose_from_rt((RotTrans() << 0.05, 0.6, -0.02, -150.0, 3.0, 40.0).finished());
  rig[2].name = "projector";
  rig[2].T_device_ref = pose_from_rt((RotTrans() << -0.1, 0.3, 0.03, -80.0, 20.0, 10.0).finished());
  return rig;
}

Correspondences drawn_points(const std::vector<ImportedDevice>& rig, double noise_px) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, noise_px);
  std::uniform_real_distribution<double> side(-30.0, 30.0);
  Correspondences seen{"drawn", {}};
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d p(side(random), side(random), 270.0 + 0.5 * side(random));
    std::vector<Eigen::Vector2d> q;
    for (const ImportedDevice& d : rig) {
      const auto at = Lens(d.lensmodel, d.intrinsics, {d.imagersize_px[0], d.imagersize_px[1]}, d.name)
                          .project(d.T_device_ref * p);
      Eigen::Vector2d seen_px = Eigen::Vector2d::Constant(std::nan(""));
      if (at) seen_px = *at + Eigen::Vector2d(noise(random), noise(random));
      q.push_back(seen_px);
    }
    seen.q_px.push_back(q);
  }
  return seen;
}

TEST(CheckPoses, EachConventionIsTold) {
  const auto rig = drawn_rig();
  const Correspondences seen = drawn_points(rig, 0.2);
  using enum PoseConvention;
  // What a file says when it means something else by R, T.
  for (const PoseConvention meant : {as_given, inverted, rotation_transposed, translation_negated}) {
    auto file = rig;
    for (ImportedDevice& d : file) d.T_device_ref = with_convention(d.T_device_ref, meant);
    for (const DeviceCheck& check : check_poses(file, seen, 3.0)) {
      EXPECT_TRUE(check.fits_any) << check.device;
      EXPECT_EQ(check.best, meant) << check.device;
      const ConventionFit& fit = check.fits[static_cast<std::size_t>(meant)];
      EXPECT_GT(fit.epipolar_px, 0.2 * 0.9);
      EXPECT_LT(fit.epipolar_px, 0.2 * 1.1 * std::sqrt(2.0));
      // Four coordinates, three of a point: one degree of freedom of noise over two images.
      EXPECT_NEAR(fit.reprojection_px, 0.2 * std::sqrt(0.5), 0.02);
      EXPECT_GT(fit.in_front, 0.99);
    }
  }
}

TEST(CheckPoses, NoConventionForOtherPoints) {
  const auto rig = drawn_rig();
  Correspondences seen = drawn_points(rig, 0.2);
  for (auto& q : seen.q_px) std::swap(q[1], q[2]);  // columns in another order
  for (const DeviceCheck& check : check_poses(rig, seen, 3.0)) EXPECT_FALSE(check.fits_any) << check.device;
  seen.q_px.resize(5);
  EXPECT_THAT(refusal([&] { (void)check_poses(rig, seen, 3.0); }), HasSubstr("see only 5 points in common"));
}

TEST_F(ImportFiles, ObservationsFromTablesAndCornerFiles) {
  const auto rig = drawn_rig();
  const Correspondences table =
      read_correspondences(write("o.csv", "x1,y1,x2,y2,x3,y3\n1,2,3,4,5,6\n7,8,nan,-,9,10 # two\n"), rig);
  ASSERT_EQ(table.q_px.size(), 2u);
  EXPECT_EQ(table.q_px[0][2], Eigen::Vector2d(5, 6));
  EXPECT_FALSE(table.q_px[1][1].allFinite());
  const Correspondences corners = read_correspondences(
      write("o.vnl",
            "# filename x y level\nleft-1.png 1 2 0\nleft-1.png 3 4 0\nright-1.png 5 6 0\nright-1.png - - -\n"
            "projector-1.png 7 8 0\nprojector-1.png 9 10 0\n"),
      rig);
  ASSERT_EQ(corners.q_px.size(), 2u);
  EXPECT_EQ(corners.q_px[0][1], Eigen::Vector2d(5, 6));
  EXPECT_FALSE(corners.q_px[1][1].allFinite());
  EXPECT_EQ(corners.q_px[1][2], Eigen::Vector2d(9, 10));
  const auto said = [&](const std::string& text) {
    return refusal([&] { (void)read_correspondences(write("bad.txt", text), rig); });
  };
  EXPECT_THAT(said("1 2 3 4\n"), HasSubstr("bad.txt:1: has 4 columns, 3 devices have 6"));
  EXPECT_THAT(said("1 2 3 4 5 6\n1 2 x 4 5 6\n"), HasSubstr("bad.txt:2: \"x\" is not a number"));
  EXPECT_THAT(said("# none\n"), HasSubstr("holds no observations"));
  EXPECT_THAT(said("1 2 3 4 5 6\n1 2 3 4 5 6 7 8\n"), HasSubstr("bad.txt:2: has 8 columns"));
}

std::vector<double> numbers_after(const std::string& text, const std::string& key, std::size_t n) {
  std::string part = text.substr(text.find("\"" + key + "\"") + key.size() + 3);
  for (char& c : part)
    if (c == '[' || c == ']' || c == ',') c = ' ';
  std::istringstream in(part);
  std::vector<double> out(n);
  for (double& v : out) in >> v;
  return out;
}

TEST_F(ImportFiles, KaminoRigReprojectsItsCorners) {
  const fs::path set = captures_root() / "kamino-procam-board";
  if (!fs::exists(set)) GTEST_SKIP() << "real captures absent: " << set << " (FRINGETWIN_CAPTURES)";
  std::ifstream json_file(set / "own_joint_calibration.json");
  std::stringstream text;
  text << json_file.rdbuf();
  const auto matrix = [&](const std::string& name, const std::string& key, std::size_t rows,
                          std::size_t cols) {
    const auto v = numbers_after(text.str(), key, rows * cols);
    std::ostringstream out;
    out.precision(17);
    for (std::size_t i = 0; i < v.size(); ++i) out << v[i] << ((i + 1) % cols == 0 ? "\n" : " ");
    return write(name, out.str());
  };
  std::vector<ImportedDevice> rig{
      import_matrices({matrix("K1", "cam_K", 3, 3), matrix("D1", "cam_D", 1, 5), {}, {}}, 1.0),
      import_matrices({matrix("K2", "proj_K", 3, 3), matrix("D2", "proj_D", 1, 5), matrix("R", "R", 3, 3),
                       matrix("T", "T_mm", 3, 1)},
                      1.0)};
  rig[0].name = "camera", rig[0].imagersize_px = {1280, 1024};
  rig[1].name = "projector", rig[1].imagersize_px = {1024, 768};
  std::ifstream csv(set / "corners_cam_proj.csv");
  std::string line, table;
  while (std::getline(csv, line)) {
    std::size_t at = 0;
    for (int k = 0; k < 3; ++k) at = line.find(',', at) + 1;  // pose, x, y of the board
    table += line.substr(at) + "\n";
  }
  const Correspondences seen = read_correspondences(write("seen.csv", table), rig);
  ASSERT_EQ(seen.q_px.size(), 315u);
  const DeviceCheck given = check_poses(rig, seen, 3.0)[0];
  EXPECT_EQ(given.best, PoseConvention::as_given);
  EXPECT_TRUE(given.fits_any);
  EXPECT_LE(given.fits[0].reprojection_px, 0.31);
  rig[1].T_device_ref = rig[1].T_device_ref.inverse();
  const DeviceCheck inverted = check_poses(rig, seen, 3.0)[0];
  EXPECT_TRUE(inverted.fits_any);
  EXPECT_EQ(inverted.best, PoseConvention::inverted);
  EXPECT_GT(inverted.fits[0].epipolar_px, 20.0);
}

}  // namespace
}  // namespace fringetwin::calib::import_test
