// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit  | origin                                                          |
// |-----------|-------|-----------------------------------------------------------------|
// | 5         | sigma | of a mean, a variance or a covariance of n draws, fixed seed    |
// | 1e-9      | 1     | relative: a pose through a rotation matrix and back             |
#include "study/uncertain/uncertain_inputs.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/base/errors.hpp"
#include "twin/file/toml_reader.hpp"

namespace fringetwin::study::uncertain_inputs_test {
namespace {

UncertainInputs inputs() {
  UncertainInputs out;
  out.keys.push_back({"height", {"object.ball.center_mm[2]"}, {270.0}, Distribution::normal, 0.5});
  out.keys.push_back(
      {"light", {"projector.intensity", "projector.ambient"}, {40.0, 1.0}, Distribution::uniform, 2.0});
  out.calibration = 2;
  return out;
}

InputDraw draw(std::uint64_t trial) { return draw_inputs(inputs(), 7, DrawStream::trials, trial); }

TEST(UncertainInputs, DistributionsOfTheKeys) {
  constexpr int n = 20'000;
  double normal = 0.0, normal2 = 0.0, uniform = 0.0, uniform2 = 0.0, across = 0.0;
  for (int i = 0; i < n; ++i) {
    const InputDraw d = draw(static_cast<std::uint64_t>(i));
    ASSERT_LT(std::abs(d.deviates[1]), 1.0);
    normal += d.deviates[0] / n;
    normal2 += d.deviates[0] * d.deviates[0] / n;
    uniform += d.deviates[1] / n;
    uniform2 += d.deviates[1] * d.deviates[1] / n;
    across += d.deviates[0] * d.calibration[0] / n;
  }
  EXPECT_NEAR(normal, 0.0, 5.0 / std::sqrt(n));
  EXPECT_NEAR(normal2, 1.0, 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(uniform, 0.0, 5.0 * std::sqrt(1.0 / 3.0 / n));
  EXPECT_NEAR(uniform2, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / n));
  EXPECT_NEAR(across, 0.0, 5.0 / std::sqrt(n));
}

TEST(UncertainInputs, PointsHoldTheDraw) {
  const InputDraw d = draw(3);
  const StudyPoint point = point_of(inputs(), 12, d);
  EXPECT_EQ(point.id, 12);
  EXPECT_EQ(point.seed, d.noise_seed);
  EXPECT_LT(point.seed, std::uint64_t{1} << 53);
  ASSERT_EQ(point.settings.size(), 4u);
  EXPECT_EQ(std::stod(point.settings.at("object.ball.center_mm[2]")), 270.0 + 0.5 * d.deviates[0]);
  EXPECT_EQ(std::stod(point.settings.at("projector.intensity")), 40.0 + 2.0 * d.deviates[1]);
  EXPECT_EQ(std::stod(point.settings.at("projector.ambient")), 1.0 + 2.0 * d.deviates[1]);
  EXPECT_EQ(point_of(inputs(), 12, draw(3)).settings, point.settings) << "a draw is its address";
  EXPECT_NE(point_of(inputs(), 12, draw(4)).settings, point.settings);
}

TEST(UncertainInputs, FactorsAreExchangedOneByOne) {
  const InputDraw a = draw(1), b = draw(2);
  ASSERT_EQ(inputs().factors(), (std::vector<std::string>{"height", "light", "calibration", "noise"}));
  for (std::size_t f = 0; f < 4; ++f) {
    const InputDraw x = exchanged(inputs(), a, b, f);
    EXPECT_EQ(x.deviates[0], (f == 0 ? b : a).deviates[0]);
    EXPECT_EQ(x.deviates[1], (f == 1 ? b : a).deviates[1]);
    EXPECT_EQ(x.calibration, (f == 2 ? b : a).calibration);
    EXPECT_EQ(x.noise_seed, (f == 3 ? b : a).noise_seed);
  }
  UncertainInputs quiet = inputs();
  quiet.calibration = 0;
  quiet.noise = false;
  EXPECT_EQ(quiet.factors().size(), 2u);
  EXPECT_EQ(draw_inputs(quiet, 7, DrawStream::trials, 1).noise_seed, 0u);
  EXPECT_EQ(draw_inputs(quiet, 7, DrawStream::trials, 1).deviates, a.deviates) << "others' draws stay";
}

TEST(UncertainInputs, AFormIsAFactorOfItsOwn) {
  UncertainInputs with = inputs();
  with.forms.push_back({"form of ball", "ball", {0.0035, 2, 12}});
  ASSERT_EQ(with.factors(),
            (std::vector<std::string>{"height", "light", "form of ball", "calibration", "noise"}));
  const InputDraw a = draw_inputs(with, 7, DrawStream::trials, 1),
                  b = draw_inputs(with, 7, DrawStream::trials, 2);
  EXPECT_EQ(a.deviates, draw(1).deviates) << "others' draws stay";
  EXPECT_EQ(a.calibration, draw(1).calibration);
  EXPECT_EQ(a.noise_seed, draw(1).noise_seed);
  ASSERT_EQ(a.forms.size(), 1u);
  EXPECT_NE(a.forms, b.forms);
  EXPECT_EQ(exchanged(with, a, b, 2).forms, b.forms);
  EXPECT_EQ(exchanged(with, a, b, 2).calibration, a.calibration);
  EXPECT_EQ(exchanged(with, a, b, 3).calibration, b.calibration);
  EXPECT_EQ(exchanged(with, a, b, 4).noise_seed, b.noise_seed);
  const StudyPoint point = point_of(with, 0, a);
  EXPECT_EQ(point.settings.at("uncertainty.form.ball"),
            std::to_string(a.forms[0]).insert(0, "[") + ", 0.0035, 2, 12]");
  EXPECT_EQ(keys_of_twin(point.settings).size(), 3u) << "keys alone";
}

// Two balls have a form each, in places of their own among the factors.
TEST(UncertainInputs, FormsAreExchangedOneByOne) {
  UncertainInputs with = inputs();
  with.forms = {{"form of ball", "ball", {0.0035, 2, 12}}, {"form of other", "other", {0.005, 3, 9}}};
  const InputDraw a = draw_inputs(with, 7, DrawStream::trials, 1),
                  b = draw_inputs(with, 7, DrawStream::trials, 2);
  ASSERT_EQ(a.forms.size(), 2u);
  EXPECT_NE(a.forms[0], a.forms[1]);
  for (std::size_t f = 0; f < with.factors().size(); ++f) {
    const InputDraw x = exchanged(with, a, b, f);
    EXPECT_EQ(x.forms[0], (f == 2 ? b : a).forms[0]) << with.factors()[f];
    EXPECT_EQ(x.forms[1], (f == 3 ? b : a).forms[1]) << with.factors()[f];
    EXPECT_EQ(x.calibration, (f == 4 ? b : a).calibration) << with.factors()[f];
    EXPECT_EQ(x.noise_seed, (f == 5 ? b : a).noise_seed) << with.factors()[f];
  }
}

TEST(UncertainInputs, TheRecordingRigHasTheForm) {
  const auto folder = testing::scratch_folder("rig_with_a_form");
  testing::write_file(folder / "twin.toml", testing::small_twin());
  const VirtualRig rig(folder / "twin.toml", false);
  const Twin drawn = rig.drawn({{"object.ball.radius_mm", "18.5"},
                                {"object.ball.center_mm", "[1, 2, 271]"},
                                {"uncertainty.form.ball", "[77, 0.02, 2, 12]"}});
  const auto* mesh = std::get_if<MeshShape>(&drawn.objects[0].shape);
  ASSERT_NE(mesh, nullptr);
  EXPECT_TRUE(mesh->smooth);
  EXPECT_EQ(mesh->T_world_object.translation_mm, Eigen::Vector3d(1, 2, 271));
  const FormSpread spread{0.02, 2, 12};
  const SphereForm form = SphereForm::draw(spread, 77);
  double mean = 0.0;  // the facets' sag, which all vertices stand outside by
  for (const Eigen::Vector3f& v : mesh->mesh->vertices_mm)
    mean += (v.cast<double>().norm() - 18.5 - form.at(v.cast<double>().normalized())) /
            static_cast<double>(mesh->mesh->vertices_mm.size());
  EXPECT_NEAR(mean, 4.0 * facet_error_mm(18.5, spread), 0.25 * mean) << "an eighth to a thirtieth";
  EXPECT_TRUE(std::holds_alternative<SphereShape>(rig.nominal().objects[0].shape));
}

class RigOfTheCalibration : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::scratch_folder("rig_of_the_calibration");
    testing::write_file(folder_ / "twin.toml",
                        testing::small_twin({}, "[uncertainty]\ncalibration = \"calibration.json\"\n"));
    testing::write_file(folder_ / "calibration.json",
                        R"({"schema": "fringetwin-calibration/1", "devices": [{"name": "left"}],
                         "covariance": {"parameters": ["projector.t1", "left.fx", "projector.t3"],
                         "matrix": [[0.04, 0.015, -0.01], [0.015, 0.0225, 0.003], [-0.01, 0.003, 0.01]]}})");
  }
  std::filesystem::path folder_;
};

TEST_F(RigOfTheCalibration, IsDrawnFromItsCovariance) {
  const VirtualRig rig(folder_ / "twin.toml", true);
  UncertainInputs only;
  only.calibration = rig.calibration_directions();
  ASSERT_EQ(only.calibration, 3u);
  constexpr int n = 3000;
  Eigen::Matrix3d found = Eigen::Matrix3d::Zero(), stated;
  stated << 0.04, 0.015, -0.01, 0.015, 0.0225, 0.003, -0.01, 0.003, 0.01;
  const Eigen::Vector3d nominal(-95.0, 260.0, 12.0);
  for (int i = 0; i < n; ++i) {
    const InputDraw d = draw_inputs(only, 3, DrawStream::trials, static_cast<std::uint64_t>(i));
    const Twin twin = rig.drawn(point_of(only, i, d).settings);
    const RotTrans rt = rt_from_pose(twin.projector->T_proj_world);
    const Eigen::Vector3d change =
        Eigen::Vector3d(rt[3], twin.cameras[0].lens.intrinsics()[0], rt[5]) - nominal;
    found += change * change.transpose() / n;
    EXPECT_NEAR(rt[1], 0.35, 0.35 * 1e-9) << "no parameter of the covariance";
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(found(i, j), stated(i, j),
                  5.0 * std::sqrt((stated(i, i) * stated(j, j) + stated(i, j) * stated(i, j)) / n));
}

TEST_F(RigOfTheCalibration, NominalAndDrawnAreTwoTwins) {
  const VirtualRig rig(folder_ / "twin.toml", true);
  const Twin drawn =
      rig.drawn({{"projector.intensity", "41.5"}, {"uncertainty.calibration.deviates", "[1, -2e-05, 0]"}});
  EXPECT_EQ(drawn.projector->intensity, 41.5);
  EXPECT_EQ(rig.nominal().projector->intensity, 40.0);
  EXPECT_NE(drawn.cameras[0].lens.intrinsics()[0], 260.0);
  EXPECT_EQ(rig.nominal().cameras[0].lens.intrinsics()[0], 260.0);
  EXPECT_EQ(VirtualRig(folder_ / "twin.toml", false).calibration_directions(), 0u);
}

TEST_F(RigOfTheCalibration, IsAskedForWhereThereIsNone) {
  testing::write_file(folder_ / "bare.toml", testing::small_twin());
  try {
    VirtualRig(folder_ / "bare.toml", true);
    FAIL() << "no refusal";
  } catch (const UserError& error) {
    EXPECT_NE(std::string(error.what()).find("names no calibration"), std::string::npos) << error.what();
  }
}

TEST_F(RigOfTheCalibration, NumbersOfTheFile) {
  const TomlTable file = TomlTable::parse_file(folder_ / "twin.toml", ExitCode::usage);
  EXPECT_EQ(file.number_at("object.ball.center_mm[2]"), 270.0);
  EXPECT_EQ(file.number_at("camera.left.intrinsics[4]"), -0.1);
  EXPECT_EQ(file.number_at("projector.intensity"), 40.0);
  EXPECT_EQ(file.number_at("projector.blur_px"), std::nullopt) << "left out";
  EXPECT_EQ(file.number_at("name"), std::nullopt) << "no number";
  EXPECT_THROW(file.number_at("object.bull.radius_mm"), UserError);
  EXPECT_THROW(file.number_at("fringes.pitches_px[7]"), UserError);
}

}  // namespace
}  // namespace fringetwin::study::uncertain_inputs_test
