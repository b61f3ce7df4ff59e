// SPDX-License-Identifier: Apache-2.0
// Which patterns an exposure sees, by hand. Tolerance 1e-15: a sum and a quotient of numbers up to 2.
#include "twin/exposure_timing.hpp"

#include <gtest/gtest.h>

#include "twin/twin.hpp"

namespace fringetwin::exposure_timing_test {
namespace {

constexpr double kRounding = 1e-15;

void expect_shares(double begin, double exposure, double before, double own, double after) {
  SCOPED_TRACE(begin);
  const ExposureParts parts = exposure_parts(begin, exposure);
  EXPECT_NEAR(parts.share[0], before, kRounding);
  EXPECT_NEAR(parts.share[1], own, kRounding);
  EXPECT_NEAR(parts.share[2], after, kRounding);
}

TEST(ExposureTiming, SharesOfThePatterns) {
  expect_shares(0.0, 1.0, 0.0, 1.0, 0.0);
  expect_shares(0.1, 1.0, 0.0, 0.9, 0.1);
  expect_shares(-0.25, 1.0, 0.25, 0.75, 0.0);
  expect_shares(0.0, 0.5, 0.0, 1.0, 0.0);
  expect_shares(0.5, 0.5, 0.0, 1.0, 0.0);  // ends with its pattern
  expect_shares(0.75, 0.5, 0.0, 0.5, 0.5);
  expect_shares(-0.125, 0.5, 0.25, 0.75, 0.0);
  expect_shares(-0.5, 0.5, 1.0, 0.0, 0.0);  // the earliest that is allowed, and the latest
  expect_shares(1.0, 0.5, 0.0, 0.0, 1.0);
}

// Each part's share at the middle of its time: together the middle of the exposure.
TEST(ExposureTiming, PartsAreSeenWhenTheirPatternIsShown) {
  const ExposureParts late = exposure_parts(0.5, 1.0);
  EXPECT_NEAR(late.middle[1], 0.75, kRounding);
  EXPECT_NEAR(late.middle[2], 1.25, kRounding);
  const ExposureParts early = exposure_parts(-0.5, 0.75);
  EXPECT_NEAR(early.middle[0], -0.25, kRounding);
  EXPECT_NEAR(early.middle[1], 0.125, kRounding);
  for (const double begin : {-0.75, -0.3, 0.0, 0.2, 0.9}) {
    const ExposureParts parts = exposure_parts(begin, 0.75);
    double middle = 0.0;
    for (std::size_t k = 0; k < 3; ++k) middle += parts.share[k] * parts.middle[k];
    EXPECT_NEAR(middle, begin + 0.375, kRounding) << begin;
  }
}

TEST(ExposureTiming, OneNumberIsThatOfAllImages) {
  ExposureTiming timing;
  EXPECT_EQ(timing.late_of(7), 0.0);
  timing.late = {0.25};
  EXPECT_EQ(timing.late_of(7), 0.25);
  timing.late = {0.25, -0.5};
  EXPECT_EQ(timing.late_of(1), -0.5);
  timing.read_out = 0.5;
  EXPECT_EQ(timing.begin(1, 0.25), -0.375);
  timing.exposure = 0.5;
  EXPECT_EQ(timing.middle(1), -0.75);  // a quarter before the middle of its pattern, and half a period early
}

TEST(ExposureTiming, OnlyWhatReachesIntoAnotherPatternSeesIt) {
  const auto sees = [](double exposure, double read_out, double late) {
    return sees_neighbours({.exposure = exposure, .read_out = read_out, .late = {late}}, 0);
  };
  EXPECT_FALSE(sees(1.0, 0.0, 0.0));
  EXPECT_TRUE(sees(1.0, 0.0, 0.001));
  EXPECT_TRUE(sees(1.0, 0.0, -0.001));
  EXPECT_TRUE(sees(1.0, 0.001, 0.0));
  EXPECT_FALSE(sees(0.5, 0.25, 0.25));
  EXPECT_FALSE(sees(0.5, 0.25, 0.125));
  EXPECT_TRUE(sees(0.5, 0.25, 0.1));
  EXPECT_TRUE(sees(0.5, 0.25, 0.4));
}

// From the sensor's upper border, -1/2, to its lower one, 1/2: the first of 10 rows has its middle half a row
// below the border. Pixels of one colour lie in every other row of their sensor.
TEST(ExposureTiming, RowsOfTheSensor) {
  const Lens lens("LENSMODEL_PINHOLE", {100.0, 100.0, 3.5, 4.5}, {8, 10}, "test");
  Camera camera{"left", lens, Pose{}, Sensor{}, std::nullopt};
  EXPECT_NEAR(camera.row_heights().of(0.0), -0.45, kRounding);
  EXPECT_NEAR(camera.row_heights().of(9.0), 0.45, kRounding);
  camera.channel = MosaicChannel{"RGGB", MosaicColour::blue, {8, 10}};
  camera.lens = image_lens(lens, *camera.channel, "test");
  EXPECT_NEAR(camera.row_heights().of(0.0), -0.35, kRounding);  // row 1 of the sensor
  EXPECT_NEAR(camera.row_heights().of(4.0), 0.45, kRounding);   // row 9
  camera.timing.emplace().rows = RowHeights{0.0, 0.1}.part(2.0, 3.0);
  EXPECT_NEAR(camera.row_heights().of(1.0), 0.5, kRounding);  // row 5 of those
}

}  // namespace
}  // namespace fringetwin::exposure_timing_test
