// SPDX-License-Identifier: Apache-2.0
// Runs of pulses with one fault each, at every place, and what is said of it. Exact: the pulse, the camera,
// the kind of fault; skews to the nanosecond they were put in with.
#include "capture/record/pulses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace fringetwin::testing::pulses_test {
namespace {

using namespace fringetwin::capture;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Kind = PulseFault::Kind;

constexpr TimeNs kIntervalNs = 20'000'000;
constexpr TimeNs kEpochNs = 1'700'000'000'000'000'000;  // of a camera that keeps the time of day

/// A camera on the line: a clock of its own that runs at `rate` and began at `offset_ns`.
struct Watcher {
  std::string camera = "left";
  TimeNs offset_ns = kEpochNs;
  double rate = 1.0;

  PulseTrain sees(const std::vector<TimeNs>& pulses_ns) const {
    PulseTrain train{camera, {}};
    for (const TimeNs at_ns : pulses_ns) {
      const auto own_ns = static_cast<TimeNs>(std::llround(rate * static_cast<double>(at_ns)));
      train.frames.push_back({offset_ns + own_ns, 65'530 + train.frames.size(), ""});
    }
    return train;
  }
};
const Watcher kRight{"right", 5'000, 1.0};

/// Pulses whose times scatter by a share of the interval, evenly.
std::vector<TimeNs> pulses(int n, double jitter = 0.0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-jitter, jitter);
  std::vector<TimeNs> times_ns;
  for (int i = 0; i < n; ++i)
    times_ns.push_back(i * kIntervalNs +
                       static_cast<TimeNs>(share(random) * static_cast<double>(kIntervalNs)));
  return times_ns;
}

template <class T>
std::vector<T> without(std::vector<T> all, std::size_t i) {
  all.erase(all.begin() + static_cast<std::ptrdiff_t>(i));
  return all;
}
std::vector<TimeNs> with(std::vector<TimeNs> all, TimeNs at_ns) {
  all.insert(std::ranges::upper_bound(all, at_ns), at_ns);
  return all;
}

void expect_one(const PulseVerdict& verdict, Kind kind, int pulse, const std::string& sentence) {
  ASSERT_EQ(verdict.faults.size(), 1u) << verdict.sentence();
  EXPECT_EQ(verdict.faults[0].kind, kind) << verdict.sentence();
  EXPECT_EQ(verdict.faults[0].pulse, pulse) << verdict.sentence();
  EXPECT_EQ(verdict.sentence(), sentence);
}

PulseTrain shared(PulseTrain train) {
  train.has_shared_clock = true;
  return train;
}

// Cameras that the network gives one clock: how far apart they are is seen, not fitted, and which pulse one
// of them lacks is known without any jitter.
TEST(Pulses, ASharedClockTellsTimesAsTheyAre) {
  const Watcher left{"left", kEpochNs, 1.0}, late{"right", kEpochNs + 3'000, 1.0};
  const auto all = pulses(12);
  const PulseVerdict right = judge_pulses({shared(left.sees(all)), shared(late.sees(all))}, 12);
  ASSERT_TRUE(right.right()) << right.sentence();
  for (const double skew_ms : right.skew_ms) EXPECT_NEAR(skew_ms, 3e-3, 1e-9);
  for (const double skew_ms : judge_pulses({left.sees(all), late.sees(all)}, 12).skew_ms)
    EXPECT_NEAR(skew_ms, 0.0, 1e-9);
  expect_one(judge_pulses({shared(left.sees(all)), shared(late.sees(without(all, 0)))}, 12), Kind::missing, 1,
             "pulse 1 of 12 is missing in camera \"right\"");
  expect_one(judge_pulses({shared(left.sees(all)), shared(late.sees(without(all, 11)))}, 12), Kind::missing,
             12, "pulse 12 of 12 is missing in camera \"right\"");
  // half an interval late: another line, or another delay
  const Watcher other{"right", kEpochNs + kIntervalNs / 2, 1.0};
  const PulseVerdict apart = judge_pulses({shared(left.sees(all)), shared(other.sees(all))}, 12);
  EXPECT_EQ(apart.count(Kind::apart), 12);
  EXPECT_THAT(apart.sentence(),
              HasSubstr("pulse 1 of 12 came 10 ms apart in cameras \"left\" and \"right\""));
}

TEST(Pulses, ARegularRunIsRight) {
  for (const int n : {1, 2, 3, 12, 24, 500})
    for (const double jitter : {0.0, 0.02}) {
      const PulseVerdict verdict = judge_pulses({Watcher().sees(pulses(n, jitter))}, n);
      EXPECT_TRUE(verdict.right()) << n << ": " << verdict.sentence();
      EXPECT_EQ(verdict.sentence(), "");
      EXPECT_THAT(verdict.skew_ms, IsEmpty());
      if (n > 2) {
        EXPECT_NEAR(verdict.interval_ms, 20.0, 20.0 * 2.0 * jitter);  // each end of an interval
      }
    }
}

TEST(Pulses, APulseThatIsMissingIsNamedAtEachPlaceInside) {
  for (const int n : {4, 5, 24})
    for (const double jitter : {0.0, 0.02})
      for (int k = 1; k < n - 1; ++k)
        expect_one(judge_pulses({Watcher().sees(without(pulses(n, jitter), static_cast<std::size_t>(k)))}, n),
                   Kind::missing, k + 1,
                   fmt::format("pulse {} of {} is missing in camera \"left\"", k + 1, n));
}

TEST(Pulses, TheFirstAndTheLastLookAlike) {
  for (const std::size_t k : {0, 23})
    expect_one(judge_pulses({Watcher().sees(without(pulses(24, 0.02), k))}, 24), Kind::too_few, 0,
               "24 pulses were expected, 23 came in camera \"left\": the first or the last is missing");
  const auto both = without(without(pulses(24), 23), 0);
  expect_one(
      judge_pulses({Watcher().sees(both)}, 24), Kind::too_few, 0,
      "24 pulses were expected, 22 came in camera \"left\": 2 are missing at the beginning, at the end, "
      "or at both");
}

// Of three pulses any may be missing where two came; of five the second and fourth.
TEST(Pulses, WhatCannotBeKnownIsNotSaid) {
  expect_one(judge_pulses({Watcher().sees(without(pulses(3), 1))}, 3), Kind::too_few, 0,
             "3 pulses were expected, 2 came in camera \"left\"");
  expect_one(judge_pulses({Watcher().sees(without(without(pulses(5), 3), 1))}, 5), Kind::too_few, 0,
             "5 pulses were expected, 3 came in camera \"left\"");
  expect_one(judge_pulses({Watcher().sees({})}, 24), Kind::too_few, 0,
             "none of 24 pulses came in camera \"left\"");
  expect_one(judge_pulses({Watcher().sees(pulses(1))}, 24), Kind::too_few, 0,
             "24 pulses were expected, 1 came in camera \"left\"");
}

TEST(Pulses, APulseThatCameTwiceIsNamedAtEachPlace) {
  for (const int n : {3, 4, 24})
    for (const double jitter : {0.0, 0.02})
      for (const double after : {0.001, 0.1, 0.3, 0.45})
        for (int k = 0; k < n; ++k) {
          const auto all = pulses(n, jitter);
          const auto twice = with(all, all[static_cast<std::size_t>(k)] + static_cast<TimeNs>(after * 2e7));
          const PulseVerdict verdict = judge_pulses({Watcher().sees(twice)}, n);
          expect_one(verdict, Kind::doubled, k + 1,
                     fmt::format("pulse {} of {} came twice in camera \"left\"", k + 1, n));
          EXPECT_EQ(std::ranges::count(verdict.frame_faults[0], "doubled"), 1);
        }
}

// One too many shortly before its pulse, or between two: the pulses themselves are still told.
TEST(Pulses, APulseTooManyBetweenTwoIsOfTheOneBefore) {
  for (const double after : {0.55, 0.7})
    for (const std::size_t k : {0, 7, 22}) {
      const auto all = pulses(24, 0.02);
      const PulseVerdict verdict =
          judge_pulses({Watcher().sees(with(all, all[k] + static_cast<TimeNs>(after * 2e7)))}, 24);
      ASSERT_EQ(verdict.faults.size(), 1u) << verdict.sentence();
      EXPECT_EQ(verdict.faults[0].kind, Kind::doubled);
      EXPECT_EQ(verdict.faults[0].pulse, static_cast<int>(k + 1));
    }
  // Before the first: two frames of it.
  expect_one(judge_pulses({Watcher().sees(with(pulses(24), -6'000'000))}, 24), Kind::doubled, 1,
             "pulse 1 of 24 came twice in camera \"left\"");
}

TEST(Pulses, SeveralFaultsAreAllNamed) {
  const auto two = without(without(pulses(24, 0.02), 16), 6);
  const PulseVerdict missing = judge_pulses({Watcher().sees(two)}, 24);
  EXPECT_EQ(missing.sentence(),
            "pulse 7 of 24 is missing in camera \"left\", pulse 17 of 24 is missing in camera \"left\"");
  const auto neighbours = without(without(pulses(24, 0.02), 7), 6);
  EXPECT_EQ(judge_pulses({Watcher().sees(neighbours)}, 24).sentence(),
            "pulse 7 of 24 is missing in camera \"left\", pulse 8 of 24 is missing in camera \"left\"");
  // As many as expected, and wrong all the same.
  const auto both = without(with(pulses(24, 0.02), 3 * kIntervalNs + 2'000'000), 11);
  EXPECT_EQ(judge_pulses({Watcher().sees(both)}, 24).sentence(),
            "pulse 4 of 24 came twice in camera \"left\", pulse 11 of 24 is missing in camera \"left\"");
  auto all = pulses(24);
  for (const std::size_t k : {20, 15, 10, 5, 3}) all = without(all, k);
  const PulseVerdict many = judge_pulses({Watcher().sees(all)}, 24);
  EXPECT_EQ(many.count(Kind::missing), 5);
  EXPECT_THAT(many.sentence(), HasSubstr("pulse 11 of 24 is missing in camera \"left\", and 2 more"));
}

// The number of one inside is then not known either.
TEST(Pulses, OneInsideAndOneAtAnEnd) {
  const auto pair = without(without(pulses(24), 6), 0);
  EXPECT_EQ(judge_pulses({Watcher().sees(pair)}, 24).sentence(),
            "24 pulses were expected, 22 came in camera \"left\": the first or the last is missing, pulse 6 "
            "from the first that came is missing in camera \"left\"");
}

TEST(Pulses, MoreThanTheSequenceHas) {
  expect_one(judge_pulses({Watcher().sees(pulses(25, 0.02))}, 24), Kind::too_many, 0,
             "24 pulses were expected, 25 came in camera \"left\"");
}

TEST(Pulses, APauseInTheSequenceIsIrregular) {
  auto paused = pulses(24);
  for (std::size_t k = 12; k < 24; ++k) paused[k] += kIntervalNs / 2;
  expect_one(judge_pulses({Watcher().sees(paused)}, 24), Kind::irregular, 13,
             "pulse 13 of 24 came 30 ms after the one before, the others 20 ms in camera \"left\"");
}

TEST(Pulses, ALostFrameIsToldFromAMissingPulse) {
  for (const std::size_t k : {1, 7, 22}) {
    PulseTrain train = Watcher().sees(pulses(24, 0.02));
    train.frames = without(train.frames, k);  // and its number with it
    expect_one(judge_pulses({train}, 24), Kind::lost, static_cast<int>(k + 1),
               fmt::format("pulse {} of 24 was lost on its way in camera \"left\"", k + 1));
  }
  PulseTrain doubled = Watcher().sees(pulses(24));  // the camera took one more, which never came
  for (std::size_t i = 9; i < 24; ++i) ++doubled.frames[i].block_id;
  expect_one(judge_pulses({doubled}, 24), Kind::lost, 0,
             "1 more frames than pulses were lost after pulse 9 of 24 in camera \"left\"");
}

TEST(Pulses, ADamagedFrameIsNamedWhateverItsTimeSays) {
  for (const std::size_t k : {0, 1, 12, 22, 23}) {
    PulseTrain train = Watcher().sees(pulses(24, 0.02));
    train.frames[k].damage = "missing packets";
    train.frames[k].camera_ns = 12;
    expect_one(judge_pulses({train}, 24), Kind::damaged, static_cast<int>(k + 1),
               fmt::format("pulse {} of 24 is damaged (missing packets) in camera \"left\"", k + 1));
  }
  PulseTrain every_second = Watcher().sees(pulses(8));
  for (std::size_t k = 1; k < 8; k += 2) every_second.frames[k].damage = "missing packets";
  const PulseVerdict verdict = judge_pulses({every_second}, 8);
  EXPECT_EQ(verdict.faults.size(), 4u) << verdict.sentence();
  EXPECT_EQ(verdict.count(Kind::damaged), 4);
  PulseTrain all = Watcher().sees(pulses(3));
  for (PulseFrame& frame : all.frames) frame.damage = "wrong length";
  EXPECT_EQ(judge_pulses({all}, 3).count(Kind::damaged), 3);
}

TEST(Pulses, AFrameThatComesAgainIsDoubled) {
  PulseTrain train = Watcher().sees(pulses(24));
  train.frames.insert(train.frames.begin() + 5, train.frames[4]);
  expect_one(judge_pulses({train}, 24), Kind::doubled, 5, "pulse 5 of 24 came twice in camera \"left\"");
}

// 50 ppm over a run of 24 pulses are a thousandth of an interval, over 10,000 half of one.
TEST(Pulses, ClocksMayDrift) {
  for (const int n : {24, 10'000}) {
    const auto all = pulses(n, 0.02);
    const PulseVerdict verdict =
        judge_pulses({Watcher().sees(all), Watcher{"right", -77, 1.0 + 50e-6}.sees(all)}, n);
    EXPECT_TRUE(verdict.right()) << verdict.sentence();
    EXPECT_LE(*std::ranges::max_element(verdict.skew_ms), 2e-6);  // times are whole nanoseconds
  }
}

TEST(Pulses, WhatTheCamerasAreApartIsTold) {
  const auto all = pulses(24, 0.02);
  PulseTrain other = kRight.sees(all);
  other.frames[9].camera_ns += 300'000;
  const PulseVerdict verdict = judge_pulses({Watcher().sees(all), other}, 24);
  EXPECT_TRUE(verdict.right()) << verdict.sentence();
  // The line through 24 differences takes 1/24 of it, and a little by its slope.
  EXPECT_NEAR(verdict.skew_ms[9], 0.3 * (1.0 - 1.0 / 24.0), 0.3 * 0.01);
}

TEST(Pulses, DroppedInOneOfTwoCameras) {
  for (std::size_t k = 0; k < 24; ++k) {
    const auto all = pulses(24, 0.02);
    const PulseVerdict verdict = judge_pulses({Watcher().sees(all), kRight.sees(without(all, k))}, 24);
    // Also the first and the last: the intervals of the other camera tell.
    expect_one(verdict, Kind::missing, static_cast<int>(k + 1),
               fmt::format("pulse {} of 24 is missing in camera \"right\"", k + 1));
    EXPECT_EQ(verdict.faults[0].camera, "right");
    expect_one(judge_pulses({Watcher().sees(without(all, k)), kRight.sees(all)}, 24), Kind::missing,
               static_cast<int>(k + 1), fmt::format("pulse {} of 24 is missing in camera \"left\"", k + 1));
  }
}

// Without scatter no interval is like no other.
TEST(Pulses, DroppedAtAnEndOfOneOfTwoOfAPerfectProjector) {
  const auto all = pulses(24);
  expect_one(judge_pulses({Watcher().sees(all), kRight.sees(without(all, 0))}, 24), Kind::too_few, 0,
             "24 pulses were expected, 23 came in camera \"right\": the first or the last is missing");
}

TEST(Pulses, AnotherFaultInEachCamera) {
  const auto all = pulses(24, 0.02);
  const PulseVerdict verdict = judge_pulses(
      {Watcher().sees(without(all, 3)), kRight.sees(with(all, 9 * kIntervalNs + 1'000'000))}, 24);
  EXPECT_EQ(verdict.sentence(),
            "pulse 4 of 24 is missing in camera \"left\", pulse 10 of 24 came twice in camera \"right\"");
  EXPECT_THAT(verdict.faults, ElementsAre(::testing::Field(&PulseFault::camera, "left"),
                                          ::testing::Field(&PulseFault::camera, "right")));
}

TEST(Pulses, CamerasOnDifferentLinesAreNotPaired) {
  const PulseVerdict verdict =
      judge_pulses({Watcher().sees(pulses(24)), Watcher{"right", 0, 1.2}.sees(pulses(24))}, 24);
  expect_one(verdict, Kind::apart, 0,
             "the pulses of camera \"right\" come at 1.200 times the interval of those of camera \"left\"");
}

TEST(Pulses, ClocksThatTickCoarselyAreRightToo) {
  PulseTrain coarse = Watcher().sees(pulses(12, 0.02));
  for (PulseFrame& frame : coarse.frames) frame.camera_ns = frame.camera_ns / 1'000'000 * 1'000'000;
  EXPECT_TRUE(judge_pulses({coarse, kRight.sees(pulses(12, 0.02))}, 12).right());
}

}  // namespace
}  // namespace fringetwin::testing::pulses_test
