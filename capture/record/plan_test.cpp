// SPDX-License-Identifier: Apache-2.0
#include "capture/record/plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/support/capture/loop_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::plan_test {
namespace {

using namespace fringetwin::capture;
using ::testing::HasSubstr;
using testing::loop_twin;

std::vector<std::string> files(const std::vector<Step>& steps) {
  std::vector<std::string> all;
  for (const Step& step : steps)
    for (const Picture& picture : step.pictures) all.push_back(picture.file("left"));
  return all;
}

TEST(CapturePlan, TheSequenceAlone) {
  const Twin twin = loop_twin(1);
  const auto steps = make_steps(twin.fringes, {});
  ASSERT_EQ(steps.size(), 8u);
  EXPECT_EQ(files(steps).front(), "left/0000.png");
  EXPECT_EQ(files(steps).back(), "left/0007.png");
  EXPECT_EQ(recorded_sets(twin.fringes, {}).size(), 1u);
}

TEST(CapturePlan, BracketsAreASetEachAndNoFileComesTwice) {
  const Twin twin = loop_twin(1);
  CapturePlan plan;
  plan.exposures_ms = {2.5, 10};
  plan.references = true;
  plan.dark_frames = 2;
  const auto all = files(make_steps(twin.fringes, plan));
  EXPECT_EQ(all.size(), 2u * (10u + 2u));
  EXPECT_THAT(all, ::testing::Contains("exposure_2.5_ms/left/white.png"));
  EXPECT_THAT(all, ::testing::Contains("exposure_10_ms/dark/left/0001.png"));
  EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), all.size());
  const auto sets = recorded_sets(twin.fringes, plan);
  ASSERT_EQ(sets.size(), 3u);
  EXPECT_EQ(sets[0].folder, "");
  EXPECT_EQ(sets[0].exposure_ms, 2.5);  // the merged set is scaled to the shortest
}

// Dark and flat frames have the exposure of the images, and are written some at a time.
TEST(CapturePlan, DarkFramesOfOneExposure) {
  const Twin twin = loop_twin(1);
  CapturePlan plan;
  plan.exposures_ms = {2};
  plan.dark_frames = 40;
  const auto steps = make_steps(twin.fringes, plan);
  ASSERT_EQ(steps.size(), 3u + 8u);
  for (const Step& step : steps) {
    EXPECT_EQ(step.exposure_ms, 2.0);
    EXPECT_LE(step.pictures.size(), 16u);
  }
  EXPECT_EQ(steps[2].pictures.back().file("left"), "dark/left/0039.png");
}

TEST(CapturePlan, WhiteAndBlackWhereTheSequenceNeedsThem) {
  Twin twin = loop_twin(1);
  GrayCode gray;
  gray.bits = 3;
  gray.threshold = GrayCode::Threshold::white_black;
  twin.fringes.directions[0].gray = gray;
  twin.fringes.unwrap = Unwrap::gray;
  twin.fringes.directions[0].pitches_px = {13.0};
  EXPECT_THAT(files(make_steps(twin.fringes, {})), ::testing::Contains("left/white.png"));
}

TEST(CapturePlan, IdentityTellsWhatMustNotChange) {
  const Twin twin = loop_twin(2);
  CapturePlan plan;
  const auto identity = plan_identity(twin, plan);
  plan.settle_frames = 7;
  plan.latency_ms = 3.0;
  plan.attempts = 1;
  EXPECT_EQ(plan_identity(twin, plan), identity);
  plan.average = 2;
  EXPECT_NE(plan_identity(twin, plan), identity);
  Twin other = twin;
  other.fringes.directions[0].phase_origin_px[1] = 0.5;
  EXPECT_NE(plan_identity(other, {}), identity);
}

TEST(CapturePlan, NumbersOutOfRange) {
  const auto sentence = [](const CapturePlan& plan) -> std::string {
    try {
      check_plan(plan);
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(sentence({}), "");
  CapturePlan plan;
  plan.average = 0;
  EXPECT_THAT(sentence(plan), HasSubstr("--average"));
  plan = {};
  plan.latency_ms = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(sentence(plan), HasSubstr("--latency-ms"));
  plan = {};
  plan.exposures_ms = {-1.0};
  EXPECT_THAT(sentence(plan), HasSubstr("--exposure-ms"));
  plan.exposures_ms = {2.0, 1.0, 2.0};
  EXPECT_THAT(sentence(plan), HasSubstr("names one exposure twice"));
}

}  // namespace
}  // namespace fringetwin::testing::plan_test
