// SPDX-License-Identifier: Apache-2.0
// Our files and our uncertainty against mrcal's own Python side and tools.
//
// | check                          | tolerance     | origin                                             |
// |--------------------------------|---------------|----------------------------------------------------|
// | intrinsics, extrinsics         | exact         | shortest round-trip decimals                       |
// | mrcal.optimize() from our file | 1e-6 px       | the solver's stopping rule; measured 1e-9          |
// | projection uncertainty         | 1e-6 relative | the same linear algebra on the same solve          |
// | 3D, stabilised, of L+R, L+P    | 0.1 relative  | mrcal: rays' midpoint; ours: pixels' least squares |
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "calib/solve/calibrate.hpp"
#include "calib/solve/uncertainty.hpp"
#include "tests/support/calib/calib_rig.hpp"
#include "tests/support/twin/child_process.hpp"

namespace fringetwin::calib::mrcal_python_test {
namespace {

using fringetwin::testing::run;
using fringetwin::testing::ScratchFolder;

class MrcalPython : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::mt19937_64 random(21);
    testing::BoardDraw draw;
    draw.least_corners = 60;
    observations_ = new Observations(testing::draw_observations(testing::true_paper_rig(), random, draw));
  }
  void SetUp() override {
    if (!fringetwin::testing::has_mrcal_python()) GTEST_SKIP() << "mrcal's Python module is not installed";
  }
  Calibration calibration(bool regularize, const std::string& model = "LENSMODEL_OPENCV4") {
    CalibrateOptions options;
    options.regularize = regularize;
    options.lensmodel = model;
    Calibration c = calibrate(*observations_, options);
    for (int d = 0; d < 3; ++d)
      write_calibrated_model(dir_ / fmt::format("camera-{}.cameramodel", d), c, d, {" a comment"});
    return c;
  }
  std::string model_file(int d) const { return (dir_ / fmt::format("camera-{}.cameramodel", d)).string(); }
  std::vector<double> python(const std::string& body) {
    const auto script =
        dir_.write("s.py",
                   "import mrcal, sys, numpy as np\nm = [mrcal.cameramodel(f) for f in sys.argv[1:4]]\n"
                   "def out(a):\n  for v in np.ravel(a): print(repr(float(v)))\n" +
                       body);
    const auto result = run(fmt::format("/usr/bin/python3 {} {} {} {} 2>&1", script.string(), model_file(0),
                                        model_file(1), model_file(2)));
    EXPECT_EQ(result.status, 0) << result.output;
    std::istringstream words(result.output);
    std::vector<double> numbers;
    for (double v = 0; words >> v;) numbers.push_back(v);
    return numbers;
  }
  static Observations* observations_;
  ScratchFolder dir_;
};
Observations* MrcalPython::observations_ = nullptr;

TEST_F(MrcalPython, ReadsOurFilesAndFindsNothingToImprove) {
  const Calibration c = calibration(true);
  const auto numbers = python(R"(
for k in m:
  out(k.intrinsics()[1])
  out(k.extrinsics_rt_fromref())
o = m[2].optimization_inputs()
before = o['intrinsics'].copy()
mrcal.optimize(**o)
out(np.max(np.abs(o['intrinsics'][:,:4] - before[:,:4])))
out(m[2].icam_intrinsics())
)");
  ASSERT_EQ(numbers.size(), 3u * 14u + 2u);
  for (std::size_t d = 0; d < 3; ++d) {
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(numbers[14 * d + i], c.problem.intrinsics[d][i]);
    for (int i = 0; i < 6; ++i)
      EXPECT_EQ(numbers[14 * d + 8 + static_cast<std::size_t>(i)],
                d == 0 ? 0.0 : c.problem.rt_cam_ref[d - 1][i]);
  }
  EXPECT_LT(numbers[42], 1e-6);
  EXPECT_EQ(numbers[43], 2.0);
}

TEST_F(MrcalPython, ProjectionUncertainty) {
  for (const auto& [regularize, model] :
       {std::pair{false, "LENSMODEL_OPENCV4"},
        {true, "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=8_fov_x_deg=44"}}) {
    const Calibration c = calibration(regularize, model);
    const auto expected = python(R"(
for k in m:
  W,H = k.imagersize()
  q = np.array(((W-1)/2,(H-1)/2, 100,80, W-101,80, 100,H-81, W-101,H-81)).reshape(5,2)
  v = mrcal.unproject(q, *k.intrinsics(), normalize=True)
  p = v / v[:,2:] * 0.27
  out(p)
  out(mrcal.projection_uncertainty(p, k, what='covariance'))
  out(mrcal.projection_uncertainty(p, k, what='worstdirection-stdev'))
  out(mrcal.projection_uncertainty(p, k, atinfinity=True, what='worstdirection-stdev'))
)");
    ASSERT_EQ(expected.size(), 3u * (15u + 20u + 5u + 5u));
    const Uncertainty uncertainty(c);
    auto next = expected.begin();
    for (int d = 0; d < 3; ++d) {
      std::vector<Eigen::Vector3d> p_mm;
      for (int i = 0; i < 5; ++i, next += 3)
        p_mm.emplace_back(1000.0 * next[0], 1000.0 * next[1], 1000.0 * next[2]);
      for (int i = 0; i < 5; ++i, next += 4) {
        const Eigen::Matrix2d m = uncertainty.projection(d, p_mm[static_cast<std::size_t>(i)]);
        const double scale = m.trace();
        EXPECT_NEAR(m(0, 0), next[0], 1e-6 * scale);
        EXPECT_NEAR(m(0, 1), next[1], 1e-6 * scale);
        EXPECT_NEAR(m(1, 1), next[3], 1e-6 * scale);
      }
      for (int i = 0; i < 5; ++i, ++next)
        EXPECT_NEAR(
            worst_direction_sigma(uncertainty.projection(d, p_mm[static_cast<std::size_t>(i)])) / *next, 1.0,
            1e-6)
            << model;
      for (int i = 0; i < 5; ++i, ++next)
        EXPECT_NEAR(
            worst_direction_sigma(uncertainty.projection_at_infinity(d, p_mm[static_cast<std::size_t>(i)])) /
                *next,
            1.0, 1e-6)
            << model;
    }
  }
}

TEST_F(MrcalPython, PointsAreAsUncertainAsMrcalSays) {
  const Calibration c = calibration(false);
  const auto expected = python(R"(
p = np.array((0.,0.,0.27))
for i in (1,2):
  q = np.array([mrcal.project(mrcal.transform_point_rt(k.extrinsics_rt_fromref(), p), *k.intrinsics()) for k in (m[0],m[i])])
  r = mrcal.triangulate(q, (m[0],m[i]), stabilize_coords=True, q_calibration_stdev=-1, q_observation_stdev=0)
  r = r[1] if isinstance(r, tuple) else r
  out(np.sqrt(np.diag(r)) * 1000)
)");
  ASSERT_EQ(expected.size(), 6u);
  const Uncertainty uncertainty(c);
  for (int d = 1; d < 3; ++d) {
    const Eigen::MatrixXd m = uncertainty.points({{0.0, 0.0, 270.0}}, {{0}, {d}});
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(std::sqrt(m(i, i)) / expected[static_cast<std::size_t>(3 * (d - 1) + i)], 1.0, 0.1)
          << d << i;
    // 0.1 px in each picture: about baseline and focal length, 11/8/21 um and 11/10/54 um with both
    // coordinates.
    const Eigen::Matrix3d noise =
        uncertainty.point_noise({0.0, 0.0, 270.0}, {{0, true, true, 0.1}, {d, true, true, 0.1}});
    EXPECT_NEAR(std::sqrt(noise(2, 2)), d == 1 ? 0.021 : 0.054, 0.006);
  }
}

TEST_F(MrcalPython, ToolsReadOurFiles) {
  const Calibration c = calibration(true);
  for (const std::string& tool :
       {"mrcal-show-projection-uncertainty --distance 0.27 --gridn 12 8 --hardcopy " +
            (dir_ / "u.svg").string() + " " + model_file(2),
        "mrcal-show-projection-diff --no-uncertainties --gridn 12 8 --hardcopy " + (dir_ / "d.svg").string() +
            " " + model_file(0) + " " + model_file(1),
        "mrcal-to-cahvor --force --outdir " + (dir_ / "").string() + " " + model_file(1)}) {
    const auto result = run("PATH=/usr/bin:$PATH " + tool + " 2>&1");
    EXPECT_EQ(result.status, 0) << tool << "\n" << result.output;
  }
}

}  // namespace
}  // namespace fringetwin::calib::mrcal_python_test
