// SPDX-License-Identifier: Apache-2.0
// Reading the covariance of a calibration, and what its parameters are in a twin.
//
// | check                         | tolerance        | origin                                   |
// |-------------------------------|------------------|------------------------------------------|
// | changed poses and intrinsics  | 1e-12            | rounding of rotation vector and products |
// | sum of changes = the covariance | 1e-10 relative | rounding of the eigenvectors             |
#include "compare/verdict/calibration_covariance.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "twin/base/errors.hpp"

namespace fringetwin::compare::calibration_covariance_test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

Twin rig() {
  Twin twin;
  twin.file = "rig.toml";
  const auto lens = [](const std::string& model, std::vector<double> intrinsics) {
    return Lens(model, intrinsics, {640, 480}, "test");
  };
  RotTrans world, right, projector;
  world << 0.2, -0.1, 0.05, 10, 20, 30;  // the first camera is not the world
  right << 0.01, 0.4, -0.02, -100, 3, 20;
  projector << -0.03, 0.2, 0.01, -50, 1, 5;
  const Pose T_left_world = pose_from_rt(world);
  Camera left{
      "left", lens("LENSMODEL_OPENCV4", {600, 601, 319, 239, -0.1, 0.05, 0, 0}), T_left_world, {}, {}};
  twin.cameras.push_back(left);
  left.name = "right";
  left.T_cam_world = pose_from_rt(right) * T_left_world;
  twin.cameras.push_back(left);
  twin.projector.emplace(Projector{.lens = lens("LENSMODEL_PINHOLE", {900, 900, 319, 239}),
                                   .T_proj_world = pose_from_rt(projector) * T_left_world,
                                   .response = {}});
  return twin;
}

class CalibrationCovarianceFile : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = fs::temp_directory_path() / ("ft_covariance_" + std::to_string(::getpid()) + ".json");
  }
  void TearDown() override { fs::remove(file_); }

  CalibrationCovariance read(const std::string& covariance, const std::string& reference = "left") {
    std::ofstream(file_) << R"({"schema": "fringetwin-calibration/1", "devices": [{"name": ")" << reference
                         << R"("}], "covariance": )" << covariance << "}";
    return read_file();
  }
  CalibrationCovariance read_file() {
    Twin twin = rig();
    twin.calibration_uncertainty = file_;
    return read_calibration_covariance(twin);
  }
  std::string error(const std::string& covariance, const std::string& reference = "left") {
    try {
      read(covariance, reference);
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input);
      EXPECT_THAT(e.what(), HasSubstr(file_.string()));
      return e.what();
    }
    ADD_FAILURE() << covariance << " was read";
    return "";
  }
  std::string of(const std::string& names, const std::string& matrix) {
    return R"({"parameters": [)" + names + R"(], "matrix": )" + matrix + "}";
  }
  fs::path file_;
};

TEST_F(CalibrationCovarianceFile, ReadsNamesAndMatrix) {
  const auto c = read(of(R"("left.k2", "projector.t3")", "[[4, 1], [1, 9]]"));
  EXPECT_EQ(c.parameters, (std::vector<std::string>{"left.k2", "projector.t3"}));
  EXPECT_EQ(c.matrix, (Eigen::Matrix2d() << 4, 1, 1, 9).finished());
}

TEST_F(CalibrationCovarianceFile, NamesWhatIsWrong) {
  const std::string two = R"("left.fx", "right.t1")";
  EXPECT_THAT(error("null"), HasSubstr("covariance is missing or null"));
  EXPECT_THAT(error(R"({"matrix": [[1]]})"), HasSubstr("covariance.parameters"));
  EXPECT_THAT(error(R"({"parameters": ["left.fx"]})"), HasSubstr("covariance.matrix is missing"));
  EXPECT_THAT(error(of(two, "[[1, 0]]")), HasSubstr("must be 2 x 2"));
  EXPECT_THAT(error(of(two, "[[1, 0], [0]]")), HasSubstr("must be 2 x 2"));
  EXPECT_THAT(error(of(two, "[[1, 0], [0, null]]")), HasSubstr("covariance.matrix[1][1] is no number"));
  EXPECT_THAT(error(of(two, "[[1, 0.5], [0.4, 1]]")), HasSubstr("not symmetric at [1][0]"));
  EXPECT_THAT(error(of(two, "[[1, 2], [2, 1]]")), HasSubstr("no covariance: [1][0]"));
  EXPECT_THAT(error(of(two, "[[1, 0], [0, -1]]")), HasSubstr("[1][1] is a negative variance"));
  EXPECT_THAT(error(of(R"("left.fx")", "[[1e308]]")), HasSubstr("covariance.matrix[0][0] is 1e+308"));
  EXPECT_THAT(error(of(two + R"(, "left.fy")", "[[1, 0.9, -0.9], [0.9, 1, 0.9], [-0.9, 0.9, 1]]")),
              HasSubstr("negative variance"));
  EXPECT_THAT(error(of(R"("left.fx", "left.fx")", "[[1, 0], [0, 1]]")), HasSubstr("there twice"));
  EXPECT_THAT(error(of(R"("middle.fx")", "[[1]]")),
              HasSubstr("names no device of the twin (left, right, projector)"));
  EXPECT_THAT(error(of(R"("fx")", "[[1]]")), HasSubstr("names no device"));
  EXPECT_THAT(error(of(R"("left.k3")", "[[1]]")), HasSubstr("no parameter of the LENSMODEL_OPENCV4"));
  EXPECT_THAT(error(of(R"("projector.k1")", "[[1]]")), HasSubstr("no parameter of the LENSMODEL_PINHOLE"));
  EXPECT_THAT(error(of(R"("left.r1")", "[[1]]")), HasSubstr("the reference of all poses"));
  EXPECT_THAT(error(of(R"("left.fx")", "[[1]]"), "right"), HasSubstr("devices[0].name"));
}

TEST_F(CalibrationCovarianceFile, RefusesOtherFiles) {
  EXPECT_THROW(read_file(), UserError);  // not there
  const std::string start = R"({"schema": "fringetwin-calibration/1", "covariance": )";
  for (const std::string& text :
       {std::string("{"), std::string("[]"), std::string("{\"schema\": \"fringetwin-result/1\"}"),
        start + R"({"parameters": ["left.fx"], "matrix": [[1e999]]}})",
        start + R"({"parameters": ["left.fx"], "matrix": [[1]]}, "devices": [{"name": 5}]})",
        start + R"({"parameters": ["left.fx"], "matrix": [[1]]}, "devices": [{}]})", std::string(100000, '['),
        start + std::string(100000, '['),
        start + R"({"parameters": ["left.fx"], "matrix": [[1]]}, "devices": )" + std::string(1000000, '[') +
            std::string(1000000, ']') + "}"}) {
    std::ofstream(file_) << text;
    EXPECT_THROW(read_file(), UserError) << text.substr(0, 100);
  }
}

TEST(CalibrationCovariance, ChangesOneParameterOnly) {
  const Twin twin = rig();
  const auto changed = [&](const std::string& name, double d) {
    return with_rig_change(twin, {"", {name}, Eigen::MatrixXd::Ones(1, 1)}, Eigen::VectorXd::Constant(1, d));
  };
  const auto relative = [](const Pose& T, const Twin& of) {
    return rt_from_pose(T * of.cameras[0].T_cam_world.inverse());
  };
  const Twin lens = changed("right.cy", 2.5);
  EXPECT_EQ(lens.cameras[1].lens.intrinsics()[3], 241.5);
  EXPECT_EQ(lens.cameras[0].lens.intrinsics()[3], 239.0);
  EXPECT_EQ(changed("left.p1", 0.01).cameras[0].lens.intrinsics()[6], 0.01);
  EXPECT_EQ(changed("projector.fx", -1.0).projector->lens.intrinsics()[0], 899.0);
  for (int i = 0; i < 6; ++i) {
    const std::string name = std::string(i < 3 ? "r" : "t") + std::to_string(i % 3 + 1);
    RotTrans expected = RotTrans::Zero();
    expected[i] = 0.01;
    const Twin right = changed("right." + name, 0.01), projector = changed("projector." + name, 0.01);
    EXPECT_TRUE((relative(right.cameras[1].T_cam_world, right) - relative(twin.cameras[1].T_cam_world, twin) -
                 expected)
                    .isZero(1e-12));
    EXPECT_TRUE((relative(projector.projector->T_proj_world, projector) -
                 relative(twin.projector->T_proj_world, twin) - expected)
                    .isZero(1e-12));
    EXPECT_EQ(right.projector->T_proj_world.translation_mm, twin.projector->T_proj_world.translation_mm);
    EXPECT_EQ(right.cameras[0].T_cam_world.translation_mm, twin.cameras[0].T_cam_world.translation_mm);
  }
}

// A calibration is of the whole sensor: its pixels are half of those of a channel's image.
TEST(CalibrationCovariance, LensOfAColourSensor) {
  Twin twin = rig();
  Camera& left = twin.cameras[0];
  left.channel = MosaicChannel{"RGGB", MosaicColour::blue, {left.lens.width(), left.lens.height()}};
  left.lens = image_lens(left.lens, *left.channel, "test");
  const auto change_of = [&](const std::string& name, double d, std::size_t i) {
    const Twin changed =
        with_rig_change(twin, {"", {name}, Eigen::MatrixXd::Ones(1, 1)}, Eigen::VectorXd::Constant(1, d));
    return changed.cameras[0].whole_lens().intrinsics()[i] - left.whole_lens().intrinsics()[i];
  };
  EXPECT_EQ(change_of("left.fx", 2.5, 0), 2.5);
  EXPECT_EQ(change_of("left.cy", -1.5, 3), -1.5);
  EXPECT_EQ(change_of("left.p1", 0.01, 6), 0.01);
}

/// Parameters of very different sizes, one that is known exactly, and two that are not independent.
TEST(CalibrationCovariance, DirectionsAddUpToIt) {
  Eigen::Matrix4d m;
  m << 4.0, 0.0, 1e-4, 0.0,  //
      0.0, 0.0, 0.0, 0.0,    //
      1e-4, 0.0, 1e-8, 0.0,  //
      0.0, 0.0, 0.0, 25.0;
  m(0, 2) = m(2, 0) = 2e-4;  // correlation 1
  const Eigen::MatrixXd c = one_sigma_changes(m);
  EXPECT_EQ(c.cols(), 2);
  const Eigen::Matrix4d sum = c * c.transpose();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      EXPECT_NEAR(sum(i, j), m(i, j), 1e-10 * std::sqrt(m(i, i) * m(j, j))) << i << " " << j;
}

}  // namespace
}  // namespace fringetwin::compare::calibration_covariance_test
