// SPDX-License-Identifier: Apache-2.0
// Real boards with a known answer.
//
// | check                        | tolerance     | origin                                              |
// |------------------------------|---------------|-----------------------------------------------------|
// | 186 views, 12 intrinsics     | 1e-8 relative | published by mrcal's author (published-opencv8.txt) |
// | 186 views, warp              | 1e-7 relative | the same                                            |
// | 31 views, rms per coordinate | 0.54 px       | mrcal22-answers.txt: 0.536; a wrong minimum has 1.7 |
// | 31 views, fx fy cx cy        | 0.05 px       | mrcal22-answers.txt                                 |
// | procam, joint rms, 2-norm    | 0.31 px       | own_joint_calibration.json: 0.262 with OpenCV       |
// | procam, column from row      | 0.36 px       | the set's README: 0.30 to 0.35 (1-px code: 0.29)    |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "calib/board/corners_vnl.hpp"
#include "calib/solve/calibrate.hpp"
#include "twin/twin.hpp"

namespace fringetwin::calib::calibration_real_test {
namespace {
namespace fs = std::filesystem;

#define SKIP_WITHOUT(file) \
  if (!fs::exists(file)) GTEST_SKIP() << "real captures absent: " << (file) << " (FRINGETWIN_CAPTURES)"

fs::path corners(const std::string& name) { return captures_root() / "mrcal-corners" / name; }

std::vector<double> numbers_of(const fs::path& file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string first;
    words >> first;
    if (first != key) continue;
    std::vector<double> out;
    for (double v = 0; words >> v;) out.push_back(v);
    return out;
  }
  return {};
}

Observations one_camera(const fs::path& file) {
  Observations o;
  o.board = {10, 10, 77.0};
  o.devices = {{"camera", {6016, 4016}, 2000.0, 1.0}};
  assign_views(read_corners_vnl(file), {"frame*.jpg"}, o);
  return o;
}

CalibrateOptions opencv8() {
  CalibrateOptions options;
  options.lensmodel = "LENSMODEL_OPENCV8";
  options.reject_outliers = false;
  return options;
}

TEST(MrcalCorners, FullSetReproducesThePublishedLens) {
  SKIP_WITHOUT(corners("corners-full-186.vnl"));
  const Calibration c = calibrate(one_camera(corners("corners-full-186.vnl")), opencv8());
  const auto published = numbers_of(corners("published-opencv8.txt"), "intrinsics");
  ASSERT_EQ(published.size(), 12u);
  for (std::size_t i = 0; i < 12; ++i)
    // The file has 12 digits.
    EXPECT_NEAR(c.devices[0].intrinsics[i] / published[i], 1.0, 1e-8) << "parameter " << i;
  const auto warp_m = numbers_of(corners("published-opencv8.txt"), "calobject_warp_m");
  EXPECT_NEAR(1e-3 * c.warp_mm.x() / warp_m[0], 1.0, 1e-7);
  EXPECT_NEAR(1e-3 * c.warp_mm.y() / warp_m[1], 1.0, 1e-7);
  EXPECT_EQ(c.fit.n_corners, 18597);
  // 0.552233 as libmrcal counts: over all measurements, with those of the 3 corners left out (0).
  const double counted = std::sqrt(c.residuals.squaredNorm() / static_cast<double>(c.residuals.size()));
  EXPECT_NEAR(counted, 0.552233, 1e-6);
}

TEST(MrcalCorners, SmallSetDoesNotFallIntoTheWrongMinimum) {
  SKIP_WITHOUT(corners("corners-small-31.vnl"));
  for (const double focal_px : {1400.0, 2000.0, 2800.0}) {
    Observations o = one_camera(corners("corners-small-31.vnl"));
    o.devices[0].focal_px = focal_px;
    const Calibration c = calibrate(o, opencv8());
    EXPECT_LE(c.fit.rms_component_px, 0.54) << focal_px;
    const double expected[] = {2073.56571, 2077.09887, 3004.24562, 1995.73029};
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(c.devices[0].intrinsics[i], expected[i], 0.05) << focal_px;
  }
}

Observations kamino(const fs::path& csv) {
  Observations o;
  o.board = {9, 7, 75.0};
  o.devices = {{"camera", {1280, 1024}, 3000.0, 1.0}, {"projector", {1024, 768}, 1500.0, 1.0}};
  std::ifstream in(csv);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    for (char& c : line)
      if (c == ',') c = ' ';
    std::istringstream words(line);
    int pose = 0;
    double x = 0, y = 0, u = 0, v = 0, px = 0, py = 0;
    words >> pose >> x >> y >> u >> v >> px >> py;
    if (static_cast<int>(o.frames.size()) <= pose) {
      o.frames.push_back(std::to_string(pose));
      o.views.push_back({0, pose, "", {}});
      o.views.push_back({1, pose, "", {}});
    }
    o.views[o.views.size() - 2].corners.push_back({{u, v}, 1.0});
    o.views.back().corners.push_back({{px, py}, 1.0});
  }
  return o;
}

/// The projector column predicted from the camera's corner and the projector row alone, minus the decoded
/// one.
double column_error_px(const Lens& camera, const Lens& projector, const Pose& T_proj_cam,
                       const Eigen::Vector2d& q_cam, const Eigen::Vector2d& q_proj, double depth_mm) {
  const Eigen::Vector3d ray = *camera.unproject(q_cam);
  double s = depth_mm / ray.z();
  for (int step = 0; step < 20; ++step) {
    Eigen::Matrix<double, 2, 3> g;
    const Eigen::Vector2d q = *projector.project(T_proj_cam * Eigen::Vector3d(s * ray), &g);
    s += (q_proj.y() - q.y()) / (g.row(1) * T_proj_cam.rotation * ray)(0);
  }
  return projector.project(T_proj_cam * Eigen::Vector3d(s * ray))->x() - q_proj.x();
}

TEST(Procam, KaminoCorrespondences) {
  const fs::path csv = captures_root() / "kamino-procam-board" / "corners_cam_proj.csv";
  SKIP_WITHOUT(csv);
  const Observations o = kamino(csv);
  ASSERT_EQ(o.views.size(), 10u);
  CalibrateOptions options;
  options.reject_outliers = false;
  for (const char* lensmodel : {"LENSMODEL_OPENCV4", "LENSMODEL_OPENCV5"}) {
    options.lensmodel = lensmodel;
    const Calibration c = calibrate(o, options);
    EXPECT_LE(c.fit.rms_px, 0.31) << lensmodel;
    EXPECT_EQ(c.fit.n_corners, 630);
    ASSERT_EQ(c.warnings.size(), 2u);  // 5 views only
    double sum = 0.0;
    for (std::size_t v = 0; v < c.observations.views.size(); v += 2)
      for (std::size_t i = 0; i < o.board.corners(); ++i) {
        const double e = column_error_px(
            c.lens(0), c.lens(1), c.devices[1].T_device_ref, c.observations.views[v].corners[i].q_px,
            c.observations.views[v + 1].corners[i].q_px, c.working_distance_mm(0));
        sum += e * e;
      }
    const double column_rms_px = std::sqrt(sum / 315.0);
    EXPECT_LE(column_rms_px, 0.36) << lensmodel;
    RecordProperty(std::string(lensmodel) + "_rms_px", fmt::format("{:.4f}", c.fit.rms_px));
    RecordProperty(std::string(lensmodel) + "_column_rms_px", fmt::format("{:.4f}", column_rms_px));
    std::printf("%s: joint rms %.4f px (camera %.4f, projector %.4f), column from row %.4f px\n", lensmodel,
                c.fit.rms_px, c.devices[0].fit.rms_px, c.devices[1].fit.rms_px, column_rms_px);
  }
}

}  // namespace
}  // namespace fringetwin::calib::calibration_real_test
