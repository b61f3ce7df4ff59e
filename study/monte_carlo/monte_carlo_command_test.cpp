// SPDX-License-Identifier: Apache-2.0
// `fringetwin study` of kind monte-carlo, as a user runs it.
// tolerance: none (the numbers: virtual_rig_test, monte_carlo_test).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::testing::monte_carlo_command_test {
namespace {
using ::testing::HasSubstr;

class MonteCarloCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    FT_NEED_DEVICE();
    write_file(folder_ / "calibration.json",
               R"({"schema": "fringetwin-calibration/1", "devices": [{"name": "left"}],
                   "covariance": {"parameters": ["projector.t1"], "matrix": [[1e-4]]}})");
    write_file(folder_ / "twin.toml", small_twin({{"gain_dn = 20", "gain_dn = 20\nread_noise_dn = 1"}},
                                                 "[uncertainty]\ncalibration = \"calibration.json\"\n"
                                                 "[render]\nsamples = 4\nsampler = \"gauss\"\n"));
    write_study("", 15);
  }
  void write_study(const std::string& extra, int most_trials) const {
    write_file(
        folder_ / "study.toml",
        "schema = \"fringetwin-study/1\"\nname = \"ball\"\nkind = \"monte-carlo\"\ntwin = \"twin.toml\"\n"
        "calibration = true\nblock_trials = 5\nleast_blocks = 2\nsensitivity_rows = 4\n"
        "most_trials = " +
            std::to_string(most_trials) + "\n" + extra +
            "[[uncertain]]\nkey = \"object.ball.center_mm[2]\"\nname = \"depth\"\nsigma = 0.05\n"
            "[[record]]\nresult = \"fits.ball.measured.center_mm[2]\"\nname = \"z_mm\"\n");
  }
  RunResult run(const std::string& out) const {
    return run_fringetwin(
        {"study", (folder_ / "study.toml").string(), "--out", (folder_ / out).string(), "--jobs", "2"});
  }
  std::filesystem::path folder_ = scratch_folder("monte_carlo_command");
};

TEST_F(MonteCarloCommand, GivesUncertaintyAndRanking) {
  const RunResult first = run("a");
  ASSERT_TRUE(first.exit_code == 0 || first.exit_code == 5) << first.err;  // 5: not converged
  const auto result = read_json(folder_ / "a" / "result.json");
  EXPECT_EQ(result["converged"], first.exit_code == 0);
  EXPECT_EQ(result["failed"], 0);
  const auto& z = result["numbers"][0];
  EXPECT_EQ(z["name"], "z_mm");
  EXPECT_EQ(z["n"], result["trials"]);
  EXPECT_GT(z["sigma"], 0.0);
  ASSERT_EQ(z["sensitivity"].size(), 3u);  // depth, calibration, noise
  EXPECT_EQ(z["sensitivity_rows"], 4);
  // The nominal twin measures: a ball 0.05 mm off is seen 0.05 mm off, the drawn projector is not known.
  EXPECT_EQ(z["sensitivity"][0]["factor"], "depth");

  const RunResult again = run("a");
  EXPECT_THAT(again.out, HasSubstr("0 points in this run"));
  const RunResult other = run("b");
  EXPECT_EQ(read_file(folder_ / "a" / "result.json"), read_file(folder_ / "b" / "result.json"));
  EXPECT_EQ(read_file(folder_ / "a" / "study.csv"), read_file(folder_ / "b" / "study.csv"));
}

TEST_F(MonteCarloCommand, GoesOnWithMoreTrials) {
  write_study("digits = 4\n", 5);  // 10 trials do not tell four digits
  const RunResult few = run("a");
  EXPECT_EQ(few.exit_code, 5);
  EXPECT_THAT(few.err, HasSubstr("cannot converge: that takes 2 blocks (least_blocks) of 5 trials "
                                 "(block_trials), and most_trials is 5; give most_trials = 10 or more, or "
                                 "block_trials = 2 or less\n"));
  write_study("digits = 4\n", 10);
  const RunResult raised = run("a");
  EXPECT_EQ(raised.exit_code, 5) << raised.err;
  EXPECT_THAT(raised.out, HasSubstr("10 trials, 0 failed, 5 points in this run"));
  EXPECT_THAT(raised.err, HasSubstr("trials 6 ... 10 of at most 10"));
  EXPECT_THAT(raised.err, ::testing::Not(HasSubstr("trials 1 ..."))) << "those are kept";
  EXPECT_THAT(raised.err, ::testing::Not(HasSubstr("cannot converge")));
  EXPECT_THAT(raised.err, HasSubstr("study 60 %"));  // of 10 trials: what there was counts
  EXPECT_THAT(raised.err, ::testing::Not(HasSubstr("study 20 %")));
  EXPECT_THAT(raised.err, HasSubstr("not converged after 10 trials: raise most_trials"));
  run("b");
  EXPECT_EQ(read_file(folder_ / "a" / "result.json"), read_file(folder_ / "b" / "result.json"));
  EXPECT_EQ(read_file(folder_ / "a" / "study.csv"), read_file(folder_ / "b" / "study.csv"));
  write_study("digits = 4\n", 9);
  const std::string result = read_file(folder_ / "a" / "result.json");
  const RunResult fewer = run("a");
  EXPECT_EQ(read_file(folder_ / "a" / "result.json"), result) << "what is refused leaves all as it was";
  EXPECT_EQ(fewer.exit_code, 2);
  EXPECT_THAT(fewer.err, HasSubstr("most_trials is 9, and the study has more trials already"));
}

// What has finished is shown as a page with its drawings; here all has, but no result is asked for.
TEST_F(MonteCarloCommand, ShowsWhatThereIsSoFar) {
  run("a");
  std::filesystem::remove(folder_ / "a" / "report.html");
  const RunResult shown = run_fringetwin(
      {"study", (folder_ / "study.toml").string(), "--out", (folder_ / "a").string(), "--so-far"});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("study \"ball\" so far: 1"));
  EXPECT_THAT(shown.out, HasSubstr("z_mm "));
  const std::string page = read_file(folder_ / "a" / "unfinished.html");
  EXPECT_THAT(page, HasSubstr("<svg"));
  EXPECT_THAT(page, ::testing::Not(HasSubstr("id=\"sensitivity\"")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a" / "report.html"));
}

TEST_F(MonteCarloCommand, NamesACalibrationThatIsNotThere) {
  write_file(folder_ / "twin.toml", small_twin());
  const RunResult refused = run("a");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("names no calibration"));
}

}  // namespace
}  // namespace fringetwin::testing::monte_carlo_command_test
