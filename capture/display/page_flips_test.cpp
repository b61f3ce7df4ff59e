// SPDX-License-Identifier: Apache-2.0
#include "capture/display/page_flips.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fringetwin::testing::page_flips_test {
namespace {

using capture::PageFlip;
using capture::PageFlips;
using capture::Refresh;
using capture::Shown;
using capture::TimeNs;
using ::testing::HasSubstr;

constexpr double period_ns = 16'666'667.0;  // 60 Hz

// A display that refreshes at exactly its period.
struct Display {
  std::uint64_t first = 1000;  // its count at time 0

  Refresh refresh(std::uint64_t n) const { return {first + n, static_cast<TimeNs>(n * 16'666'667)}; }
  // Asked for after refresh n, shown at refresh n + refreshes.
  PageFlip flip(std::uint64_t n, std::uint64_t refreshes) const {
    const Refresh shown = refresh(n + refreshes);
    return {refresh(n), static_cast<std::uint32_t>(shown.sequence), shown.at_ns, shown.at_ns + 50'000};
  }
};

TEST(PageFlips, SteadyFlipsCarryTheDriversTimeAndCount) {
  PageFlips flips(period_ns, true);
  const Display display;
  for (std::uint64_t n = 0; n < 100; ++n) {
    const Shown shown = flips.add(display.flip(n, 1));
    EXPECT_TRUE(shown.timed);
    EXPECT_EQ(shown.sequence, 1001 + n);
    EXPECT_EQ(shown.at_ns, display.refresh(n + 1).at_ns);
  }
  EXPECT_EQ(flips.count(), 100u);
  EXPECT_EQ(flips.missed(), 0u);
  EXPECT_EQ(flips.untimed(), 0u);
}

// As vkms gave them on a slow virtual machine: the flip is a refresh or more too late, its stamp is right.
TEST(PageFlips, MissedRefreshesAreCounted) {
  PageFlips flips(period_ns, true);
  const Display display;
  EXPECT_EQ(flips.add(display.flip(0, 1)).sequence, 1001u);
  EXPECT_EQ(flips.add(display.flip(1, 2)).sequence, 1003u);
  EXPECT_EQ(flips.add(display.flip(7, 4)).sequence, 1011u);
  EXPECT_EQ(flips.add(display.flip(20, 1)).sequence, 1021u);  // idle refreshes in between are not missed
  EXPECT_EQ(flips.missed(), 1u + 3u);
  EXPECT_EQ(flips.untimed(), 0u);
}

// A flip asked for in the blanking interval can still belong to the refresh that was counted already.
TEST(PageFlips, AFlipWithinTheCountedRefreshIsTimed) {
  PageFlips flips(period_ns, true);
  const Shown shown = flips.add(Display{}.flip(5, 0));
  EXPECT_TRUE(shown.timed);
  EXPECT_EQ(shown.sequence, 1005u);
  EXPECT_EQ(flips.missed(), 0u);
}

TEST(PageFlips, TheEventsCountIsContinuedBeyond32Bits) {
  PageFlips flips(period_ns, true);
  const Display display{0xffff'fffe};  // events: ffff ffff, 0, 1, 2 ...
  for (std::uint64_t n = 0; n < 4; ++n) {
    const Shown shown = flips.add(display.flip(n, 1));
    EXPECT_TRUE(shown.timed) << flips.why_untimed();
    EXPECT_EQ(shown.sequence, 0xffff'ffffULL + n);
  }
  EXPECT_EQ(flips.missed(), 0u);
}

void expect_untimed(const PageFlip& flip, bool monotonic, const std::string& reason) {
  PageFlips flips(period_ns, monotonic);
  const Shown shown = flips.add(flip);
  EXPECT_FALSE(shown.timed) << reason;
  EXPECT_EQ(shown.sequence, 0u);
  EXPECT_EQ(shown.at_ns, flip.received_ns);
  EXPECT_EQ(flips.untimed(), 1u);
  EXPECT_EQ(flips.missed(), 0u);
  EXPECT_THAT(flips.why_untimed(), HasSubstr(reason));
}

// virtio-gpu and bochs: no count to ask for, events at once with sequence 0.
TEST(PageFlips, DriversWithoutVerticalBlankingAreUntimed) {
  expect_untimed({std::nullopt, 0, 5'000'000, 5'050'000}, true, "does not count refreshes");
  expect_untimed({Refresh{0, 0}, 0, 5'000'000, 5'050'000}, true, "stays 0");
}

TEST(PageFlips, StampsOfAnotherClockAreNotUsed) {
  expect_untimed(Display{}.flip(3, 1), false, "CLOCK_MONOTONIC");
}

TEST(PageFlips, StampsThatDoNotFollowTheModeAreNotUsed) {
  PageFlip flip = Display{}.flip(3, 1);
  flip.at_ns += 9'000'000;  // more than half a period
  expect_untimed(flip, true, "1 refreshes in 25.67 ms");
  flip = Display{}.flip(3, 1);
  flip.at_ns += 8'000'000;  // less
  PageFlips flips(period_ns, true);
  EXPECT_TRUE(flips.add(flip).timed);
}

TEST(PageFlips, ACountThatGoesBackIsNotUsed) {
  PageFlip flip = Display{}.flip(3, 1);
  flip.sequence -= 5;
  expect_untimed(flip, true, "went back");
}

}  // namespace
}  // namespace fringetwin::testing::page_flips_test
