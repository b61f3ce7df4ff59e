// SPDX-License-Identifier: Apache-2.0
// tolerance: none, step numbers are exact.
#include "twin/captures/measured_steps.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/base/errors.hpp"

namespace fringetwin::measured_steps_test {
namespace {
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Twin twin_of(int steps, const std::vector<std::string>& objects) {
  Twin twin;
  twin.file = "rig/twin.toml";
  twin.fringes.steps = steps;
  twin.objects.push_back({"ball", SphereShape{}, {}});
  for (const std::string& which : objects)
    twin.objects.push_back({"relief " + which, MeasuredShape{.steps = which}, {}});
  return twin;
}

std::string refusal(const Twin& twin) {
  try {
    left_over_steps(twin);
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    return e.what();
  }
  ADD_FAILURE() << "not refused";
  return "";
}

TEST(MeasuredSteps, WhatOneObjectLeaves) {
  EXPECT_THAT(left_over_steps(twin_of(8, {"even"})), ElementsAre(1, 3, 5, 7));
  EXPECT_THAT(left_over_steps(twin_of(7, {"odd"})), ElementsAre(0, 2, 4, 6));
  EXPECT_THAT(left_over_steps(twin_of(8, {"all"})), IsEmpty());
  EXPECT_THAT(left_over_steps(twin_of(8, {})), IsEmpty());
}

// The last object's steps alone would compare the first object with the steps it was built from.
TEST(MeasuredSteps, SeveralObjectsLeaveWhatNoneOfThemUses) {
  EXPECT_THAT(left_over_steps(twin_of(8, {"even", "even"})), ElementsAre(1, 3, 5, 7));
  EXPECT_THAT(refusal(twin_of(8, {"even", "odd"})),
              AllOf(HasSubstr("leave 0 of the 8"), HasSubstr("relief odd")));
  EXPECT_THAT(refusal(twin_of(8, {"even", "all"})), HasSubstr("leave 0 of the 8"));
  EXPECT_THAT(left_over_steps(twin_of(8, {"all", "all"})), IsEmpty());
}

TEST(MeasuredSteps, BothSidesNeedThreeSteps) {
  EXPECT_THAT(left_over_steps(twin_of(6, {"even"})), ElementsAre(1, 3, 5));
  EXPECT_THAT(refusal(twin_of(5, {"even"})), AllOf(HasSubstr("leave 2 of the 5"), HasSubstr("6 or more")));
  EXPECT_THAT(refusal(twin_of(5, {"odd"})), HasSubstr("steps = \"odd\" takes 2 of the 5"));
  const Twin four = twin_of(4, {"even"});
  EXPECT_THROW(built_from_steps(four, four.objects[1], std::get<MeasuredShape>(four.objects[1].shape)),
               UserError);
  const Twin five = twin_of(5, {"even"});
  EXPECT_THAT(built_from_steps(five, five.objects[1], std::get<MeasuredShape>(five.objects[1].shape)),
              ElementsAre(0, 2, 4));
}

}  // namespace
}  // namespace fringetwin::measured_steps_test
