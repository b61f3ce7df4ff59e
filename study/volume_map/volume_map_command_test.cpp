// SPDX-License-Identifier: Apache-2.0
// `fringetwin study` of kind volume-map against closed forms: a rig that is moved as a whole changes no
// spacing, one whose baseline is longer by e measures everything smaller by 1/(1 + e). | tolerance | unit |
// origin                                                                              |
// |-----------|------|-------------------------------------------------------------------------------------|
// | 0.003     | mm   | of a mean: pixels of 0.35 mm shift a fit by up to 0.0015, place by place            |
// | 1 %       | 1    | of a sigma of 0.03 mm and more: 0.0003 mm of the same that goes with the change     |
// | 0.001     | mm   | of a sigma that is zero: the same                                                   |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "study/statistics/monte_carlo.hpp"
#include "study/uncertain/uncertain_inputs.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::volume_map_command_test {
namespace {
using ::testing::HasSubstr;

constexpr int kTrials = 6;

class VolumeMapCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    FT_NEED_DEVICE();
    write_file(folder_ / "twin.toml", small_twin({{"gain_dn = 20", "bit_depth = 12\ngain_dn = 320"},
                                                  {"imagersize = [160, 120]", "imagersize = [480, 360]"},
                                                  {"[260, 260, 79.5, 59.5,", "[780, 780, 239.5, 179.5,"},
                                                  {"-95, 0, 12]", "-95, 0, 0]"},
                                                  {"radius_mm = 19", "radius_mm = 8"}},
                                                 "[render]\nsamples = 16\nsampler = \"gauss\"\n"));
  }
  nlohmann::json map(const std::string& name, const std::string& uncertain,
                     const std::string& lattice =
                         "center_mm = [0, 0, 270]\nsize_mm = [40, 0, 20]\n"
                         "counts = [2, 1, 2]\n") {
    write_file(folder_ / "study.toml",
               "schema = \"fringetwin-study/1\"\nkind = \"volume-map\"\ntwin = \"twin.toml\"\nobject = "
               "\"ball\"\nnoise = false\nseed = 5\n" +
                   lattice + "trials = " + std::to_string(kTrials) + "\n[[uncertain]]\n" + uncertain);
    run_ = run_fringetwin(
        {"study", (folder_ / "study.toml").string(), "--out", (folder_ / name).string(), "--jobs", "2"});
    EXPECT_EQ(run_.exit_code, 0) << run_.err;
    return read_json(folder_ / name / "result.json");
  }
  /// Deviates of the only key.
  static std::vector<double> deviates() {
    study::UncertainInputs inputs;
    inputs.keys.push_back({"k", {"k"}, {0.0}, study::Distribution::normal, 1.0});
    std::vector<double> out;
    for (std::uint64_t t = 0; t < kTrials; ++t)
      out.push_back(study::draw_inputs(inputs, 5, study::DrawStream::trials, t).deviates[0]);
    return out;
  }
  std::filesystem::path folder_ = scratch_folder("volume_map_command");
  RunResult run_;
};

TEST_F(VolumeMapCommand, ABaselineErrorScalesEverySpacing) {
  const auto result = map("scale", "key = \"projector.rt_cam_world[3]\"\nsigma = 0.19\n");
  std::vector<double> scale_error;  // the recording rig has the baseline 95 - 0.19 z
  for (const double z : deviates()) scale_error.push_back(1.0 / (1.0 - 0.002 * z) - 1.0);
  const study::SampleSummary want = study::summarise(scale_error, 0.95);
  ASSERT_EQ(result["spacing"]["pairs"].size(), 6u);
  for (const auto& pair : result["spacing"]["pairs"]) {
    const double length = pair["length_mm"];
    EXPECT_EQ(pair["n"], kTrials);
    EXPECT_NEAR(pair["error_mm"]["mean"].get<double>(), want.mean * length, 0.003) << length;
    EXPECT_NEAR(pair["error_mm"]["sigma"].get<double>() / (want.sigma * length), 1.0, 0.01) << length;
  }
  for (const auto& position : result["positions"]) {
    EXPECT_NEAR(position["size_mm"]["sigma"].get<double>(), want.sigma * 16.0, 0.001);
    EXPECT_NEAR(
        position["z_mm"]["sigma"].get<double>() / (want.sigma * position["center_mm"][2].get<double>()), 1.0,
        0.01);
  }
  const std::string table = read_file(folder_ / "scale" / "result.json");
  const auto again = map("scale", "key = \"projector.rt_cam_world[3]\"\nsigma = 0.19\n");
  EXPECT_THAT(run_.out, HasSubstr("0 points in this run"));
  EXPECT_EQ(read_file(folder_ / "scale" / "result.json"), table);
}

TEST_F(VolumeMapCommand, ARigThatIsMovedChangesNoSpacing) {
  const auto result =
      map("move", "keys = [\"camera.left.rt_cam_world[4]\", \"projector.rt_cam_world[4]\"]\nsigma = 0.3\n");
  const study::SampleSummary want = study::summarise(deviates(), 0.95);
  for (const auto& position : result["positions"]) {
    EXPECT_NEAR(position["y_mm"]["sigma"].get<double>() / (0.3 * want.sigma), 1.0, 0.01);
    EXPECT_LT(position["z_mm"]["sigma"].get<double>(), 0.001);
  }
  for (const auto& pair : result["spacing"]["pairs"]) {
    EXPECT_NEAR(pair["error_mm"]["mean"].get<double>(), 0.0, 0.003);
    EXPECT_LT(pair["error_mm"]["sigma"].get<double>(), 0.001);
  }
}

TEST_F(VolumeMapCommand, APositionThatNoCameraSeesIsShownAsSuch) {
  const auto result = map("lost", "key = \"projector.intensity\"\nsigma = 0.1\n",
                          "center_mm = [300, 0, 270]\nsize_mm = [600, 0, 0]\ncounts = [2, 1, 1]\n");
  EXPECT_EQ(result["measured"], 1);
  EXPECT_EQ(result["positions"][1]["failed"], kTrials);
  EXPECT_THAT(result["positions"][1]["reason"].get<std::string>(), HasSubstr("no camera sees"));
  EXPECT_THAT(run_.err, HasSubstr("no camera sees"));
}

}  // namespace
}  // namespace fringetwin::testing::volume_map_command_test
