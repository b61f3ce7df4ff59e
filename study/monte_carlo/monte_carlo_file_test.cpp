// SPDX-License-Identifier: Apache-2.0
// tolerance: none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/study_file.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::monte_carlo_file_test {
namespace {
using namespace fringetwin::study;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kHead = "schema = \"fringetwin-study/1\"\ntwin = \"twin.toml\"\nkind = \"monte-carlo\"\n";
const std::string kDepth = "[[uncertain]]\nkey = \"object.ball.center_mm[2]\"\nsigma = 0.5\n";

class MonteCarloFile : public ::testing::Test {
 protected:
  void SetUp() override { write_file(folder_ / "twin.toml", small_twin()); }
  StudyFile load(const std::string& text) const {
    write_file(folder_ / "study.toml", kHead + text);
    return load_study(folder_ / "study.toml");
  }
  void expect_refused(const std::string& text, const std::string& sentence) const {
    try {
      load(text);
      ADD_FAILURE() << "no refusal of " << text;
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      EXPECT_THAT(error.what(), HasSubstr(sentence));
    }
  }
  std::filesystem::path folder_ = scratch_folder("monte_carlo_file");
};

TEST_F(MonteCarloFile, SaysWhatIsUncertain) {
  const StudyFile study = load(
      "seed = 9\ndigits = 2\nblock_trials = 50\nleast_blocks = 3\nmost_trials = 700\nsensitivity_rows = 20\n"
      "coverage = 0.9\nnoise = false\ncalibration = true\n" +
      kDepth +
      "[[uncertain]]\nkeys = [\"projector.intensity\", \"projector.ambient\"]\nname = \"light\"\nvalue = 3\n"
      "half_width = 2\ndistribution = \"uniform\"\n[[record]]\nresult = \"fits.ball.measured.radius_mm\"\n");
  ASSERT_TRUE(std::holds_alternative<MonteCarloPlan>(study.plan));
  const MonteCarloPlan& plan = std::get<MonteCarloPlan>(study.plan);
  EXPECT_TRUE(plan.calibration);
  EXPECT_EQ(plan.seed, 9u);
  EXPECT_EQ(plan.rule.digits, 2);
  EXPECT_EQ(plan.rule.coverage, 0.9);
  EXPECT_EQ(plan.rule.trials_per_block(), 50u);
  EXPECT_EQ(plan.rule.least_blocks, 3u);
  EXPECT_EQ(plan.most_trials, 700u);
  EXPECT_EQ(plan.sensitivity_rows, 20u);
  EXPECT_FALSE(plan.inputs.noise);
  ASSERT_EQ(plan.inputs.keys.size(), 2u);
  EXPECT_EQ(plan.inputs.keys[0].name, "object.ball.center_mm[2]");
  EXPECT_THAT(plan.inputs.keys[0].values, ElementsAre(270.0)) << "the twin's own value";
  EXPECT_EQ(plan.inputs.keys[0].distribution, Distribution::normal);
  EXPECT_EQ(plan.inputs.keys[0].spread, 0.5);
  EXPECT_EQ(plan.inputs.keys[1].distribution, Distribution::uniform);
  EXPECT_THAT(plan.inputs.keys[1].values, ElementsAre(3.0, 3.0));
  EXPECT_EQ(study.head.records.size(), 1u);
}

TEST_F(MonteCarloFile, SaysWhichSphereIsNotQuiteOne) {
  const StudyFile study = load(
      "[[uncertain]]\nform = \"ball\"\nrms_mm = 0.0035\n[[record]]\nresult = "
      "\"fits.ball.measured.rms_mm\"\n");
  const UncertainInputs& inputs = std::get<MonteCarloPlan>(study.plan).inputs;
  ASSERT_EQ(inputs.forms.size(), 1u);
  EXPECT_EQ(inputs.forms[0].object, "ball");
  EXPECT_EQ(inputs.forms[0].name, "form of ball");
  EXPECT_EQ(inputs.forms[0].spread.rms_mm, 0.0035);
  EXPECT_EQ(inputs.forms[0].spread.low, 2);
  EXPECT_EQ(inputs.forms[0].spread.high, 12);
  const std::string form = "[[uncertain]]\nform = \"ball\"\nrms_mm = 0.0035\n";
  EXPECT_EQ(std::get<MonteCarloPlan>(load(form + "degrees = [3, 6]\nname = \"f\"\n").plan)
                .inputs.forms[0]
                .spread.high,
            6);
  expect_refused("[[uncertain]]\nform = \"bull\"\nrms_mm = 0.0035\n", "no sphere of the twin");
  expect_refused("[[uncertain]]\nform = \"ball\"\n", "rms_mm");
  expect_refused(form + "degrees = [1, 6]\n", "degrees");
  expect_refused(form + "degrees = [6, 3]\n", "degrees");
  expect_refused(form + "degrees = [2, 3.5]\n", "whole numbers");
  expect_refused(form + form, "a second time");
  expect_refused(form + "key = \"projector.intensity\"\n", "key");
}

TEST_F(MonteCarloFile, DefaultsAreThoseOfMeasurementsThatTakeTime) {
  const StudyFile study = load("");  // noise alone
  const MonteCarloPlan& plan = std::get<MonteCarloPlan>(study.plan);
  EXPECT_TRUE(plan.inputs.noise);
  EXPECT_FALSE(plan.calibration);
  EXPECT_EQ(plan.rule.digits, 1);
  EXPECT_EQ(plan.rule.trials_per_block(), 100u);
  EXPECT_EQ(plan.rule.least_blocks, 5u);
}

TEST_F(MonteCarloFile, RefusesWhatMakesNoSense) {
  expect_refused("noise = false\n", "nothing is uncertain");
  expect_refused("[[uncertain]]\nkey = \"projector.intensity\"\n", "either sigma or half_width");
  expect_refused("[[uncertain]]\nkey = \"projector.intensity\"\nsigma = 0\n", "sigma");
  expect_refused("[[uncertain]]\nkey = \"projector.intensity\"\nsigma = 1\ndistribution = \"uniform\"\n",
                 "takes half_width");
  expect_refused("[[uncertain]]\nkey = \"projector.blur_px\"\nsigma = 1\n", "has no number in the twin");
  expect_refused("[[uncertain]]\nkey = \"object.bull.radius_mm\"\nsigma = 1\n", "bull");
  expect_refused(kDepth + kDepth, "a second time");
  expect_refused("most_trials = 10\nsensitivity_rows = 11\n", "must not exceed most_trials");
  expect_refused("coverage = 1\n", "between 0 and 1");
  expect_refused("points = 3\n", "points");
  expect_refused("[[vary]]\nkey = \"projector.intensity\"\nvalues = [1]\n", "vary");
}

}  // namespace
}  // namespace fringetwin::testing::monte_carlo_file_test
