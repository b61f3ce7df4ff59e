// SPDX-License-Identifier: Apache-2.0
// `fringetwin study` of kind optimise where reasoning knows the answer.
// | tolerance | unit | origin                                                                             |
// |-----------|------|------------------------------------------------------------------------------------|
// | -10, +2 % | 1    | of the light at which the first pixel is full: sigma of eight trials is 1/light     |
// |           |      | within 6 % (points that come and go), so the least may lie that much lower; a      |
// |           |      | fringe's maximum is up to 2 % lower in the mean over a pixel                       |
// | 0.05      | mm   | mean radius: pixels of 1 mm (sphere_form_rig_test); 2 mm off were out of the gate  |
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::optimise_command_test {
namespace {
using ::testing::HasSubstr;

class OptimiseCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    FT_NEED_DEVICE();
    write_file(
        folder_ / "twin.toml",
        small_twin({{"gain_dn = 20", "bit_depth = 12\ngain_dn = 320\nread_noise_dn = 16\nexposure_ms = 10"},
                    {"[13, 14, 15]", "[39, 42, 45]"}},
                   "[render]\nsamples = 4\nsampler = \"gauss\"\n"));
  }
  RunResult run(const std::string& out, const std::string& text, const std::string& jobs = "2") const {
    write_file(folder_ / "study.toml",
               "schema = \"fringetwin-study/1\"\nkind = \"optimise\"\ntwin = \"twin.toml\"\n" + text);
    return run_fringetwin(
        {"study", (folder_ / "study.toml").string(), "--out", (folder_ / out).string(), "--jobs", jobs});
  }
  std::filesystem::path folder_ = scratch_folder("optimise_command");
};

const std::string kLight =
    "evaluations = 12\ntrials = 2\n[[choose]]\nkey = \"projector.intensity\"\nrange = [10, 90]\n"
    "[minimise]\nresult = \"fits.ball.measured.radius_mm\"\n"
    "[[constraint]]\nresult = \"images.left.saturated\"\nmax = ";

// The brighter, the less the noise of a gray value counts: the best is where the first pixel is full,
// 320 x 0.8/pi x light = 4094.5.
TEST_F(OptimiseCommand, LightGoesUpToSaturation) {
  const RunResult first = run("a", kLight + "0.0\n");
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const auto result = read_json(folder_ / "a" / "result.json");
  ASSERT_TRUE(result["best"].is_number());
  EXPECT_LE(result["evaluations"].size(), 12u);
  const auto& best = result["evaluations"][result["best"].get<std::size_t>()];
  const double light = std::stod(best["values"]["projector.intensity"].get<std::string>());
  const double limit = 4094.5 * std::numbers::pi / (320.0 * 0.8);
  EXPECT_GT(light, 0.90 * limit);
  EXPECT_LT(light, 1.02 * limit);
  EXPECT_EQ(best["constraints"][0]["mean"], 0.0);
  EXPECT_GT(best["objective"], 0.0);
  EXPECT_NEAR(best["objective_sigma"].get<double>() / best["objective"].get<double>(), 1.0 / std::sqrt(2.0),
              1e-9);
  EXPECT_TRUE(best["theory"].is_null()) << "the closed form knows no constraint";
  EXPECT_EQ(best["time_s"], 0.12);
  std::size_t full = 0;
  for (const auto& e : result["evaluations"]) full += e["feasible"] == false;
  EXPECT_GT(full, 0u) << "the limit was seen from the other side, too";

  EXPECT_THAT(run("a", kLight + "0.0\n").out, HasSubstr("0 points in this run"));
  EXPECT_EQ(run("b", kLight + "0.0\n", "1").exit_code, 0);
  for (const char* file : {"result.json", "study.csv"})
    EXPECT_EQ(read_file(folder_ / "a" / file), read_file(folder_ / "b" / file)) << file;
}

// The sigma of the radius is 1/(light sqrt(steps)) but for points at the limit of contrast: the closed form
// puts 60 W before all others. Two steps are no phase shifting.
TEST_F(OptimiseCommand, TheClosedFormPutsTheBoxInOrder) {
  const RunResult r =
      run("theory",
          "trials = 2\n[[choose]]\nkey = \"projector.intensity\"\nvalues = [20, 48, 25, 40, 30]\n"
          "[[choose]]\nkey = \"fringes.steps\"\nvalues = [8, 2]\n"
          "[minimise]\nresult = \"fits.ball.measured.radius_mm\"\n");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, HasSubstr("5 settings put in order by their closed form, without measurements\n"
                               "5 settings left out that are no valid twin: "));
  const auto result = read_json(folder_ / "theory" / "result.json");
  ASSERT_EQ(result["evaluations"].size(), 5u);
  EXPECT_EQ(result["evaluations"][0]["values"]["projector.intensity"], "48");
  EXPECT_EQ(result["evaluations"][4]["values"]["projector.intensity"], "20");
  EXPECT_EQ(result["left_out"], 5);
  const double theory = result["evaluations"][result["best"].get<std::size_t>()]["theory"];
  EXPECT_LT(result["chosen"]["objective_interval"][0], theory);
  EXPECT_GT(result["chosen"]["objective_interval"][1], theory);
}

TEST_F(OptimiseCommand, NothingFeasibleIsExitCodeFive) {
  const RunResult r = run("none",
                          "evaluations = 3\ntrials = 2\n[[choose]]\nkey = \"projector.intensity\"\n"
                          "range = [80, 90]\n[minimise]\nresult = \"fits.ball.measured.rms_mm\"\n"
                          "[[constraint]]\nresult = \"images.left.saturated\"\nmax = 0.0\n");
  EXPECT_EQ(r.exit_code, 5);
  EXPECT_THAT(r.err, HasSubstr("meets all constraints"));
  EXPECT_TRUE(read_json(folder_ / "none" / "result.json")["best"].is_null());
}

// The ball is put elsewhere, and the rig that measures knows.
TEST_F(OptimiseCommand, ThePartsPlaceAndTheStepsAreLists) {
  const RunResult r =
      run("lists",
          "trials = 2\n[[choose]]\nkey = \"object.ball.center_mm[2]\"\nvalues = [262, 270, 278]\n"
          "[[choose]]\nkey = \"fringes.steps\"\nvalues = [3, 6]\n[[uncertain]]\n"
          "key = \"object.ball.center_mm[2]\"\nsigma = 0.01\n"
          "[minimise]\nresult = \"fits.ball.measured.radius_mm\"\nstatistic = \"rms-error\"\n"
          "value = 19\n[[constraint]]\nresult = \"fits.ball.measured.radius_mm\"\nmin = 18\n");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const auto result = read_json(folder_ / "lists" / "result.json");
  ASSERT_EQ(result["evaluations"].size(), 6u);
  for (const auto& e : result["evaluations"]) {
    EXPECT_EQ(e["failed"], 0);
    EXPECT_NEAR(e["constraints"][0]["mean"].get<double>(), 19.0, 0.05) << e["values"].dump();
    EXPECT_NEAR(e["time_s"].get<double>(), e["values"]["fringes.steps"] == "3" ? 0.09 : 0.18, 1e-12);
  }
  EXPECT_GE(result["front"].size(), 1u);
}

}  // namespace
}  // namespace fringetwin::testing::optimise_command_test
