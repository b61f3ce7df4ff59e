// SPDX-License-Identifier: Apache-2.0
// [camera.timing] of twin.toml. No tolerances: decimals that are parsed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/twin/twin_file_fixture.hpp"

namespace fringetwin::testing::twin_file_timing_test {
namespace {
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class TwinFileTiming : public TwinFile {
 protected:
  static std::string text(const std::string& keys) {
    return kHead + kCamera + "[camera.timing]\n" + keys + kFringes;  // 12 images
  }
  ExposureTiming timing(const std::string& keys) const { return load(text(keys)).cameras[0].timing.value(); }
  std::string wrong(const std::string& line, const std::string& others = "") const {
    return error(text(others + line), line);
  }
};

TEST_F(TwinFileTiming, KeysAreRead) {
  EXPECT_FALSE(load(kMinimal).cameras[0].timing);
  EXPECT_FALSE(load(text("")).cameras[0].timing) << "a table without keys asks for nothing";
  const ExposureTiming late = timing("late = 0.1\n");
  EXPECT_EQ(late.exposure, 1.0);
  EXPECT_EQ(late.read_out, 0.0);
  EXPECT_THAT(late.late, ElementsAre(0.1));
  const ExposureTiming all =
      timing("exposure = 0.75\nread_out = 0.25\nlate = [0, 0, 0, 0.5, 0, 0, -0.125, 0, 0, 0, 0, 0.0625]\n");
  EXPECT_EQ(all.exposure, 0.75);
  EXPECT_EQ(all.read_out, 0.25);
  EXPECT_EQ(all.late_of(3), 0.5);
  EXPECT_EQ(all.late_of(6), -0.125);
  EXPECT_EQ(all.late_of(11), 0.0625);
  EXPECT_EQ(timing("read_out = 1\n").late_of(5), 0.0);
}

TEST_F(TwinFileTiming, NumbersHaveTheirRanges) {
  EXPECT_THAT(wrong("exposure = 0\n"), HasSubstr("must be > 0 and <= 1"));
  EXPECT_THAT(wrong("exposure = 1.5\n"), HasSubstr("must be > 0 and <= 1"));
  EXPECT_THAT(wrong("exposure = 1e-4\n"), HasSubstr("must be at least 0.001"));
  EXPECT_THAT(wrong("read_out = -0.1\n"), HasSubstr("must be >= 0 and <= 1"));
  EXPECT_THAT(wrong("late = 2\n"), HasSubstr("must be >= -1 and <= 1"));
  EXPECT_THAT(wrong("late = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -2]\n"), HasSubstr("must be >= -1 and <= 1"));
  EXPECT_THAT(wrong("late = [0, 0.1]\n"), HasSubstr("has 2 numbers, the sequence has 12 images"));
  EXPECT_THAT(wrong("late = \"0.1\"\n"), HasSubstr("must be a number"));
  EXPECT_THAT(wrong("readout = 0.1\n"), HasSubstr("did you mean \"read_out\"?"));
}

// The first row of a sensor of 640 x 480 begins half a read-out before its middle.
TEST_F(TwinFileTiming, NoExposureReachesBeyondTheNeighbours) {
  EXPECT_THAT(wrong("late = -0.75\n", "exposure = 0.5\n"), HasSubstr("end before its own pattern begins"));
  EXPECT_THAT(wrong("late = -0.4\n", "exposure = 0.5\nread_out = 0.5\n"),
              HasSubstr("keep late - read_out/2 >= -exposure = -0.5"));
  EXPECT_THAT(wrong("late = [0, 0, 0, 0, 0, 0, 0.9, 0, 0, 0, 0, 0]\n", "read_out = 0.5\n"),
              HasSubstr("image 6 begin after its own pattern ends"));
  EXPECT_THAT(wrong("late = 0.9\n", "read_out = 0.5\n"), HasSubstr("keep late + read_out/2 <= 1"));
  EXPECT_EQ(timing("late = -0.25\nexposure = 0.5\nread_out = 0.5\n").late_of(0), -0.25);  // just allowed
  EXPECT_EQ(timing("late = 0.75\nread_out = 0.5\n").late_of(0), 0.75);
  // without late, the read-out alone
  EXPECT_THAT(any_error(text("exposure = 0.25\nread_out = 0.75\n")),
              HasSubstr("an image end before its own"));
}

}  // namespace
}  // namespace fringetwin::testing::twin_file_timing_test
