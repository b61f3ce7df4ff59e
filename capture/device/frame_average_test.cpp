// SPDX-License-Identifier: Apache-2.0
#include "capture/device/frame_average.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/base/errors.hpp"

namespace fringetwin::testing::frame_average_test {
namespace {

using namespace fringetwin::capture;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

ImageU16 frame(std::vector<std::uint16_t> values) {
  ImageU16 image(static_cast<int>(values.size()), 1);
  image.data = std::move(values);
  return image;
}

TEST(FrameAverage, MeanOfFrames) {
  FrameAverage average(8, 8);
  average.add(frame({10, 0, 200}), "cam");
  average.add(frame({11, 0, 100}), "cam");
  EXPECT_EQ(average.count(), 2);
  EXPECT_THAT(average.stored().data, ElementsAre(10.5f, 0.0f, 150.0f));
}

TEST(FrameAverage, AClippedPixelStaysSaturated) {
  FrameAverage average(8, 8);
  average.add(frame({255, 254}), "cam");
  average.add(frame({10, 10}), "cam");
  EXPECT_THAT(average.stored().data, ElementsAre(255.0f, 132.0f));
}

// Full scale goes to full scale: 4095/255 per DN.
TEST(FrameAverage, DeeperFilesHoldTheAverage) {
  FrameAverage average(8, 12);
  for (const int value : {100, 101, 101, 101})
    average.add(frame({static_cast<std::uint16_t>(value), 255, 0}), "cam");
  EXPECT_NEAR(average.stored()(0, 0), 100.75 * 4095.0 / 255.0, 1e-3);
  EXPECT_EQ(average.stored()(1, 0), 4095.0f);
  EXPECT_EQ(average.stored()(2, 0), 0.0f);
}

TEST(FrameAverage, WordsWiderThanTheSensor) {
  FrameAverage average(16, 12);
  average.add(frame({4094, 4095}), "cam");
  EXPECT_THAT(average.stored().data, ElementsAre(4094.0f, 4095.0f));
  try {
    average.add(frame({4096, 0}), "/dev/video7");
    FAIL();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("/dev/video7: delivers the value 4096, above the 4095 of bit_depth = 12"));
  }
}

TEST(FrameAverage, ManyFramesDoNotOverflow) {
  FrameAverage average(16, 16);
  for (int i = 0; i < 10'000; ++i) average.add(frame({65534}), "cam");
  EXPECT_EQ(average.stored()(0, 0), 65534.0f);
}

TEST(FrameAverage, ADeeperFileNeedsSeveralFrames) {
  EXPECT_NO_THROW(check_depths("left", 8, 8, false));
  EXPECT_NO_THROW(check_depths("left", 8, 12, true));
  EXPECT_NO_THROW(check_depths("left", 16, 12, false));
  EXPECT_THROW(check_depths("left", 8, 12, false), UserError);
}

}  // namespace
}  // namespace fringetwin::testing::frame_average_test
