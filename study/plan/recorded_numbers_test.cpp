// SPDX-License-Identifier: Apache-2.0
// tolerance: none, numbers are taken over as they are.
#include "study/plan/recorded_numbers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "report/json.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::recorded_numbers_test {
namespace {

using study::pick_numbers;
using study::Record;
using ::testing::HasSubstr;

const report::Json result = report::Json::parse(R"({"fits": [
  {"object": "ball", "kind": "sphere", "measured": {"center_mm": [1.5, -2, 0.1], "radius_mm": 19.125, "n": 7}},
  {"object": "wall", "kind": "plane", "measured": {"normal": null, "rms_mm": null, "n": 0}}],
  "decode": [{"camera": "left", "n_valid": 12}, {"camera": "right", "n_valid": 11}]})");

double one(const std::string& path) { return pick_numbers(result, {{path, ""}}).at(path); }

std::string refusal(const std::string& path) {
  try {
    one(path);
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

TEST(Record, ByNameAndByIndex) {
  EXPECT_EQ(one("fits.ball.measured.radius_mm"), 19.125);
  EXPECT_EQ(one("fits[0].measured.center_mm[2]"), 0.1);
  EXPECT_EQ(one("decode.right.n_valid"), 11.0);
  EXPECT_EQ(pick_numbers(result, {{"decode[1].n_valid", "seen"}}).at("seen"), 11.0);
}

TEST(Record, WhatIsUnknownIsNaN) {
  EXPECT_TRUE(std::isnan(one("fits.wall.measured.rms_mm")));
  EXPECT_TRUE(std::isnan(one("fits.wall.measured.normal[1]")));
}

TEST(Record, WhatIsNotFiniteIsNaNAsInAFile) {
  const report::Json with_infinity = {{"rms", std::numeric_limits<double>::infinity()}};
  EXPECT_TRUE(std::isnan(pick_numbers(with_infinity, {{"rms", ""}}).at("rms")));
}

TEST(Record, NoneMeansAllNumbersOfTheFits) {
  const auto all = pick_numbers(result, {});
  EXPECT_EQ(all.size(), 8U);
  EXPECT_EQ(all.at("fits.ball.measured.center_mm[1]"), -2.0);
  EXPECT_TRUE(std::isnan(all.at("fits.wall.measured.rms_mm")));
}

TEST(Record, AWrongPathSaysWhatThereIs) {
  EXPECT_THAT(refusal("fits.ball.measured.radius"),
              HasSubstr("there is no \"radius\"; there is: center_mm, radius_mm, n"));
  EXPECT_THAT(refusal("fits.cube.measured.rms_mm"), HasSubstr("there is: ball, wall"));
  EXPECT_THAT(refusal("fits[2].measured.n"), HasSubstr("there is no \"[2]\""));
  EXPECT_THAT(refusal("fits.ball.measured.center_mm"), HasSubstr("is no number; add an index"));
  EXPECT_THAT(refusal("fits.ball.kind"), HasSubstr("is no number"));
}

}  // namespace
}  // namespace fringetwin::testing::recorded_numbers_test
