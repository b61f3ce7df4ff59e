// SPDX-License-Identifier: Apache-2.0
// Which causes are named of fits with planted chi2, and what is said of them.
#include "compare/causes/cause_decision.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fringetwin::compare::cause_decision_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr double kBefore = 5000.0;

TEST(CauseDecision, TheOneThatPassesIsNamed) {
  EXPECT_THAT(explaining_alike({{1000, 3, false}, {1040, 3, true}, {4000, 6, true}}, kBefore, 1.0),
              ElementsAre(1));
}

TEST(CauseDecision, NothingIsNamedThatDoesNotPass) {
  EXPECT_THAT(explaining_alike({{1000, 3, false}, {1001, 1, false}}, kBefore, 1.0), IsEmpty());
}

TEST(CauseDecision, WhatDiffersByLessThanTheNoiseIsNamedTogetherFewestParametersFirst) {
  const std::vector<TriedCause> tried{{1000, 6, true}, {1024.9, 3, true}, {1025.1, 1, true}};
  EXPECT_THAT(explaining_alike(tried, kBefore, 1.0), ElementsAre(1, 0));
  EXPECT_THAT(explaining_alike(tried, kBefore, 1.1), ElementsAre(2, 1, 0));  // more noise than stated
}

TEST(CauseDecision, MoreNoisePredictedIsNoBetterFit) {
  // 10,000 values of unit variance: where 2 % more is predicted, chi2 falls by 196 and the logarithms rise by
  // 198
  const TriedCause exact{1000, 3, true}, noisier{1000 - 196, 3, true, 198};
  EXPECT_THAT(explaining_alike({exact, noisier}, kBefore, 1.0), UnorderedElementsAre(0, 1));
}

TEST(CauseDecision, NumbersOfAFieldTakeOffAsMuchNoiseAsThereIs) {
  // 10,000 values with 8 % more noise than stated: the right cause of 3 numbers leaves 10,800 and one for
  // each number, a field of 4000 numbers 1.08 * 6000 and one for each, which is the same but for chance
  const TriedCause right{10803, 3, true}, field{1.08 * 6000 + 4000, 4000, true};
  EXPECT_THAT(explaining_alike({right, field}, 60000, 1.08), ElementsAre(0, 1));
  EXPECT_THAT(explaining_alike({right, field}, 60000, 1.0), ElementsAre(1));  // if noise were as stated
}

TEST(CauseDecision, LessNoiseThanStatedNamesNoFieldOfManyNumbers) {
  // 10,000 values with 3 % less noise than stated: an offset of each of 1000 pixels leaves 0.97 * 9000 and
  // one for each number, a factor besides, which is for nothing, 0.97 * 8000
  const TriedCause offset{0.97 * 9000 + 1000, 1000, true}, both{0.97 * 8000 + 2000, 2000, true};
  EXPECT_THAT(explaining_alike({both, offset}, 60000, 0.97), ElementsAre(1, 0));
}

TEST(CauseDecision, WhatTakesAwayNoMoreThanChanceIsNotNamed) {
  EXPECT_THAT(explaining_alike({{kBefore - 27.9, 3, true}}, kBefore, 1.0), IsEmpty());
  EXPECT_THAT(explaining_alike({{kBefore - 28.1, 3, true}}, kBefore, 1.0), ElementsAre(0));
  // 800 numbers: 25 + 5 sqrt(1600)
  EXPECT_THAT(explaining_alike({{kBefore - 224, 800, true}}, kBefore, 1.0), IsEmpty());
  EXPECT_THAT(explaining_alike({{kBefore - 226, 800, true}}, kBefore, 1.0), ElementsAre(0));
}

/// Causes with rows of some groups.
Causes some(std::vector<std::string> together) {
  Causes causes;
  causes.chi2_limit = 1.16;
  causes.together = std::move(together);
  for (const char* group : {"pose", "size", "blur", "light", "room_light"}) {
    CauseRow row;
    row.group = group;
    row.cause = std::string("wrong ") + group;
    row.alone = 0.4;
    causes.rows.push_back(row);
  }
  causes.rows[1].removed = 900.0;
  causes.rows[1].chi2_after = 1.3;
  causes.rows[1].regions_after = {{"level", 1.1, 1.4, 60}, {"shift", 5.66, 1.4, 60}};
  return causes;
}

TEST(CauseDecision, SentencesSayWhatWasFound) {
  EXPECT_EQ(sentence(Causes{}), "");
  EXPECT_THAT(
      sentence(some({})),
      HasSubstr("nearest: wrong size, 40 % of it, which leaves chi2 1.3, limit 1.16; shift of regions "
                "5.66, limit 1.4)"));
  EXPECT_THAT(sentence(some({"blur"})), HasSubstr("most likely cause: wrong blur; it explains 40.0 %"));
  EXPECT_THAT(sentence(some({"blur"})), HasSubstr("Fit it with --refine blur"));
  EXPECT_THAT(sentence(some({"blur + pose"})), HasSubstr("causes: wrong blur and wrong pose: together they"));
  EXPECT_THAT(sentence(some({"blur + pose"})), HasSubstr("Fit them with --refine blur,pose"));
  Causes fitted = some({"blur + pose"});
  fitted.refined = {"blur"};
  EXPECT_THAT(sentence(fitted), HasSubstr("Fit them with --refine blur,pose"));
  fitted.refined = {"pose", "blur"};
  EXPECT_THAT(sentence(fitted), HasSubstr("They were fitted just now"));
  EXPECT_THAT(sentence(some({"light"})),
              HasSubstr("Fit it with --refine light; or have it taken out by [measure] light"));
  EXPECT_THAT(sentence(some({"room_light"})), HasSubstr("What to do: record again in the dark"));
  EXPECT_THAT(sentence(some({"pose", "size", "pose + blur"})),
              HasSubstr("wrong pose, wrong size or wrong pose and wrong blur: each explains"));
  EXPECT_THAT(sentence(some({"pose", "size"})), HasSubstr("their images differ by less than the noise"));
}

}  // namespace
}  // namespace fringetwin::compare::cause_decision_test
