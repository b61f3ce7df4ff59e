// SPDX-License-Identifier: Apache-2.0
#include "capture/genicam/frame_count.hpp"

#include <gtest/gtest.h>

namespace fringetwin::testing::frame_count_test {
namespace {

using namespace fringetwin::capture;

constexpr TimeNs ms = 1'000'000;

TEST(BlockCount, ShortIdsGoOnBehindTheirLast) {
  BlockCount count;
  EXPECT_EQ(count.number(65533), 65533u);
  EXPECT_EQ(count.number(65535), 65535u);
  EXPECT_EQ(count.number(1), 65536u);
  EXPECT_EQ(count.number(4), 65539u);  // two lost
  EXPECT_EQ(count.number(4), 65539u);  // again
  EXPECT_EQ(count.number(3), 65538u);  // late
  EXPECT_EQ(count.number(5), 65540u);
}

// A buffer whose first packet was lost tells what was in it before.
TEST(BlockCount, DamagedBlocksAreNotBelievedBlindly) {
  BlockCount count;
  bool trusted = true;
  EXPECT_EQ(count.number_of_damaged(0, &trusted), 0u);
  EXPECT_FALSE(trusted);
  EXPECT_EQ(count.number(65533), 65533u);
  EXPECT_EQ(count.number_of_damaged(65526, &trusted), 65534u);
  EXPECT_FALSE(trusted);
  EXPECT_EQ(count.number_of_damaged(65535, &trusted), 65535u);
  EXPECT_TRUE(trusted);
  EXPECT_EQ(count.number_of_damaged(0, &trusted), 65536u);  // a buffer that had none before
  EXPECT_FALSE(trusted);
  EXPECT_EQ(count.number(2), 65537u);
}

TEST(BlockCount, SomeCamerasCountFromZero) {
  BlockCount count;
  count.number(65535);
  EXPECT_EQ(count.number(0), 65536u);
  EXPECT_EQ(count.number(1), 65537u);
}

TEST(BlockCount, LongIdsDoNotWrap) {
  BlockCount count;
  count.number(65535);
  EXPECT_EQ(count.number(65536), 65536u);
  EXPECT_EQ(count.number(65538), 65538u);
  EXPECT_EQ(count.number(2), 2u);  // begun anew, which the order of frames calls repeated
}

TEST(TriggerClock, AFrameBegunBeforeItsTriggerHasItsOwnTime) {
  constexpr TimeNs offset = 777'777 * ms;  // of the program's clock from the camera's
  TriggerClock clock;
  // a command takes 0.2 ms to the camera
  const auto triggered = [&](TimeNs sent) { return clock.begin_ns(sent + ms / 5 - offset, sent); };
  for (TimeNs sent = 800'000 * ms; sent < 800'500 * ms; sent += 50 * ms) EXPECT_EQ(triggered(sent), sent);
  // begun 30 ms before the trigger: a command that came twice
  const TimeNs sent = 800'550 * ms, begun = sent - 30 * ms;
  const TimeNs got = clock.begin_ns(begun - offset, sent);
  EXPECT_LT(got, sent - 29 * ms);
  EXPECT_NEAR(static_cast<double>(got - begun), 0.0, 0.3 * ms);
  EXPECT_EQ(triggered(800'600 * ms), 800'600 * ms);
}

TEST(TriggerClock, SlowCommandsAreNoStaleFramesForLong) {
  TriggerClock clock;
  clock.begin_ns(1'020 * ms, 1'000 * ms);                         // 20 ms to the camera; the others at once
  EXPECT_LT(clock.begin_ns(1'100 * ms, 1'100 * ms), 1'100 * ms);  // in doubt for one frame
  EXPECT_EQ(clock.begin_ns(1'200 * ms, 1'200 * ms), 1'200 * ms);
  EXPECT_EQ(clock.begin_ns(1'300 * ms, 1'300 * ms), 1'300 * ms);
}

TEST(TriggerClock, ClocksThatDriftAndCamerasWithoutOne) {
  for (const double drift : {-1.5e-4, 1.5e-4}) {
    TriggerClock clock;
    for (int i = 0; i < 2000; ++i) {
      const TimeNs sent = 1'000'000 * ms + i * 100 * ms;
      const auto camera = static_cast<TimeNs>((1.0 + drift) * static_cast<double>(sent));
      EXPECT_EQ(clock.begin_ns(camera, sent), sent);
    }
  }
  TriggerClock clock;
  EXPECT_EQ(clock.begin_ns(0, 5 * ms), 5 * ms);
  EXPECT_EQ(clock.begin_ns(0, 500 * ms), 500 * ms);
}

}  // namespace
}  // namespace fringetwin::testing::frame_count_test
