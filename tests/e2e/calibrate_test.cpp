// SPDX-License-Identifier: Apache-2.0
// `fringetwin calibrate` as a user runs it: from a corner file to models that the twin reads; faults in the
// input end in one sentence, exit code 3, and nothing written.
//
// | check               | tolerance | origin                                            |
// |---------------------|-----------|---------------------------------------------------|
// | fx of three devices | 5 sigma   | its own sigma (their scatter: calib/slow/scatter) |
// | models against JSON | exact     | both in shortest round-trip decimals              |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "calib/board/corners_vnl.hpp"
#include "tests/support/calib/calib_rig.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/file/cameramodel.hpp"
#include "twin/twin.hpp"

namespace fringetwin::testing::calibrate_test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class Calibrate : public ::testing::Test {
 protected:
  void SetUp() override {
    dir_ = scratch_folder("calibrate");
    std::mt19937_64 random(31);
    testing::BoardDraw draw;
    draw.n_boards = 14;
    draw.least_corners = 60;
    observations_ = testing::draw_observations(rig_, random, draw);
  }
  void write_corners() {
    calib::write_corners_vnl(dir_ / "corners.vnl", testing::image_corners(observations_));
  }
  RunResult calibrate(std::vector<std::string> more = {}, const std::string& spacing = "0.012") {
    std::vector<std::string> args{"calibrate",
                                  "--corners-cache",
                                  (dir_ / "corners.vnl").string(),
                                  "--lensmodel",
                                  "LENSMODEL_OPENCV4",
                                  "--focal",
                                  "2000",
                                  "--imagersize",
                                  "1440x1080,1440x1080,1280x720",
                                  "--object-spacing",
                                  spacing,
                                  "--object-width-n",
                                  "10",
                                  "--object-height-n",
                                  "8",
                                  "--names",
                                  "left,right,projector",
                                  "--outdir",
                                  (dir_ / "rig").string(),
                                  "left-*",
                                  "right-*",
                                  "projector-*"};
    args.insert(args.end(), more.begin(), more.end());
    return run_fringetwin(args);
  }
  fs::path dir_;
  testing::TrueRig rig_ = testing::true_paper_rig();
  calib::Observations observations_;
};

TEST_F(Calibrate, FromCornersToATwin) {
  write_corners();
  const RunResult run = calibrate();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("RMS reprojection error: 0.09"));
  EXPECT_THAT(run.out, HasSubstr("calobject_warp: "));
  const Twin twin = load_twin(dir_ / "rig" / "twin.toml");
  ASSERT_EQ(twin.cameras.size(), 2u);
  ASSERT_TRUE(twin.projector);
  const auto json = read_json(dir_ / "rig" / "calibration.json");
  EXPECT_EQ(json["schema"].get<std::string>(), "fringetwin-calibration/1");
  EXPECT_EQ(json["views"].size(), observations_.views.size());
  EXPECT_EQ(json["boards"].size(), 14u);
  EXPECT_EQ(json["cross_validation"]["n_even"].get<int>(), 7);
  EXPECT_EQ(json["cross_validation"]["devices"].size(), 3u);
  for (std::size_t d = 0; d < 3; ++d) {
    const auto& device = json["devices"][d];
    const double sigma = device["intrinsics_sigma"][0];
    EXPECT_GT(sigma, 0.05);
    EXPECT_LT(sigma, 1.0);
    EXPECT_LT(std::abs(device["intrinsics"][0].get<double>() - rig_.lenses[d].intrinsics()[0]), 5.0 * sigma);
    const CameraModelFile model = read_cameramodel(dir_ / "rig" / device["model"].get<std::string>());
    EXPECT_EQ(model.intrinsics, device["intrinsics"].get<std::vector<double>>());
    EXPECT_THAT(model.extra, HasSubstr("'optimization_inputs': b'"));
    EXPECT_THAT(model.comments.at(0), HasSubstr("generated with"));
    EXPECT_GT(device["projection_sigma"]["centre_px"].get<double>(), 0.003);
    EXPECT_LT(device["projection_sigma"]["centre_px"].get<double>(), 0.1);
  }
  EXPECT_EQ(twin.cameras[1].lens.intrinsics(), json["devices"][1]["intrinsics"].get<std::vector<double>>());
  const std::string page = read_file(dir_ / "rig" / "calibration.html");
  for (const char* part : {"left: rms", "projector at", "even - odd", "deflection of the board",
                           "boards, oblique", "right-13.png"})
    EXPECT_THAT(page, HasSubstr(part));
}

TEST_F(Calibrate, FaultsEndInOneSentence) {
  const calib::Observations good = observations_;
  write_corners();
  const auto refused = [&](const RunResult& run, int code, const std::string& sentence) {
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_THAT(run.err, HasSubstr(sentence));
    EXPECT_FALSE(fs::exists(dir_ / "rig"));
  };
  refused(calibrate({}, "12"), 3,
          "the spacing is in metres, and this looks like millimetres; did you mean 0.012?");
  refused(calibrate({"fourth-*"}), 2, "--names: has 3 names for 4 globs");
  refused(calibrate({"--max-rms", "0.05"}), 5, "left: its corners fit to 0.1");
  refused(calibrate({"--circle-diameter", "8"}), 2,
          "--circle-diameter: circles of 8 m do not fit on a board with a spacing of 0.012 m");
  auto& corners = observations_.views[7].corners;  // frame 2, right
  std::reverse(corners.begin(), corners.end());
  write_corners();
  refused(calibrate(), 3, "right, view 2 (right-2.png): the corners of right run in the reverse order");
  observations_.views[7].corners[5].q_px.x() = std::nan("");
  observations_.views[7].corners[5].weight = 1.0;
  write_corners();
  refused(calibrate(), 3, "the corner of right-2.png is not finite");

  observations_ = calib::select_frames(good, {1, 4, 7});
  write_corners();
  refused(calibrate(), 3, "left: sees the board in 3 views only; at least 4 are needed");

  observations_ = good;
  for (auto& view : observations_.views)
    if (view.device < 2) view.device = 1 - view.device;
  write_corners();
  refused(calibrate(), 3, "the two cameras look swapped; exchange their images or their names");

  testing::TrueRig other_rig = rig_;
  other_rig.board.spacing_mm = 10.0;
  std::mt19937_64 random(12);
  testing::BoardDraw draw;
  draw.n_boards = 1;
  const calib::Observations other = testing::draw_observations(other_rig, random, draw);
  observations_ = good;
  for (auto& view : observations_.views)
    if (view.frame == 4) view.corners = other.find(view.device, 0)->corners;
  write_corners();
  refused(calibrate(), 3, "view 4 (right-4.png): it shows another board: its corners are");
}

}  // namespace
}  // namespace fringetwin::testing::calibrate_test
