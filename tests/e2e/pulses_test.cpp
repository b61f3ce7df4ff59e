// SPDX-License-Identifier: Apache-2.0
// `fringetwin capture` with a projector that runs by itself, as a user runs it: its pictures, what is refused
// beside it, and recordings whose pulses the test sends to a GigE Vision camera in software. Every image
// recorded has one right content: the picture that was loaded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>

#include "capture/device/pattern.hpp"
#include "tests/support/capture/fake_gige.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::pulses_e2e_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kWidth = 160, kHeight = 120;
constexpr TimeNs kIntervalNs = 20'000'000;

std::string twin_of_one_camera() {
  return small_twin({{"imagersize = [1280, 720]", "imagersize = [160, 120]"}});
}

/// A pulse of a run: the number of its picture, and when it comes, in intervals.
struct Pulse {
  int picture = 0;
  double at = 0.0;
};
using PulseRow = std::vector<Pulse>;

class PulsedRig {
 public:
  explicit PulsedRig(const std::string& name) : dir_(scratch_folder("pulses_" + name)) {
    write_file(dir_ / "twin.toml", twin_of_one_camera());
    twin_ = load_twin(dir_ / "twin.toml");
    fake.show([this](const GigeFrame& frame) { return picture(at_, frame.width, frame.height); });
  }

  const fs::path& dir() const { return dir_; }
  int n_patterns() const { return static_cast<int>(sequence_patterns(twin_.fringes).size()); }
  PulseRow whole() const {
    PulseRow run;
    for (int k = 0; k < n_patterns(); ++k) run.push_back({k, 1.0 * k});
    return run;
  }
  PulseRow dropped(int k) const {
    PulseRow run = whole();
    run.erase(run.begin() + k);
    return run;
  }
  PulseRow doubled(int k) const {
    PulseRow run = whole();
    run.insert(run.begin() + k + 1, Pulse{k, k + 0.2});
    return run;
  }

  /// Each run begins once the camera waits, and well after the pause that ends the one before.
  RunResult capture(const std::vector<PulseRow>& runs, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"capture", (dir_ / "twin.toml").string(), "--camera", "left=genicam:T01",
                               "--control", "left:OffsetX=0", "--trigger", "Line0", "--pause-ms", "200",
                               "--out", (dir_ / "real").string()});
    auto program = std::async(std::launch::async, [more] { return run_fringetwin(more); });
    while (!fake.awaits_pulse() && program.wait_for(5ms) != std::future_status::ready) {
    }
    for (const PulseRow& run : runs) {
      if (program.wait_for(1s) == std::future_status::ready) break;
      for (const Pulse& pulse : run) {
        at_ = pulse.picture;
        EXPECT_TRUE(
            fake.pulse(1'000'000'000 + static_cast<TimeNs>(pulse.at * static_cast<double>(kIntervalNs))));
      }
    }
    return program.get();
  }

  /// Returns how many of the recorded images are there and how many are not the picture they stand for.
  std::pair<int, int> recorded_and_wrong() const {
    int recorded = 0, wrong = 0;
    for (int k = 0; k < n_patterns(); ++k) {
      const fs::path file = dir_ / "real/left" / fmt::format("{:04}.png", k);
      if (!fs::exists(file)) continue;
      ++recorded;
      wrong += !std::ranges::equal(read_gray(file).image.data, picture(k, kWidth, kHeight).data);
    }
    return {recorded, wrong};
  }

  FakeGige fake;

 private:
  ImageU16 picture(int k, int width, int height) const {
    const Pattern pattern = sequence_patterns(twin_.fringes)[static_cast<std::size_t>(k)];
    return quantise_levels(pattern_levels(twin_.fringes, pattern, width, height), 8);
  }

  fs::path dir_;
  Twin twin_;
  std::atomic<int> at_ = 0;
};

TEST(PulsedCapture, EveryPulseIsItsImage) {
  PulsedRig rig("whole");
  const RunResult run = rig.capture({rig.whole()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("armed; waiting for the first pulse on Line0"));
  EXPECT_EQ(rig.recorded_and_wrong(), std::pair(rig.n_patterns(), 0));
  EXPECT_EQ(run_fringetwin({"capture", "--verify", (rig.dir() / "real").string()}).exit_code, 0);
  const std::string toml = read_file(rig.dir() / "real/capture.toml");
  for (const char* part :
       {"\"trigger left\" = \"Line0, a pulse for each frame\"", "\"control.TriggerMode left\" = \"On\"",
        "\"control.TriggerSource left\" = \"Line0\"", "\"projector timing\" = \"its pulses\""})
    EXPECT_THAT(toml, HasSubstr(part));
  EXPECT_EQ(run_fringetwin({"measure", (rig.dir() / "twin.toml").string(), "--captures",
                            (rig.dir() / "real").string(), "--out", (rig.dir() / "out").string()})
                .exit_code,
            0);
  const RunResult again = rig.capture({}, {"--resume"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.err, HasSubstr("nothing left to do"));
}

TEST(PulsedCapture, WrongRunsAreNamedAndTakenAgain) {
  PulsedRig rig("wrong");
  const int n = rig.n_patterns();
  const RunResult run = rig.capture({rig.dropped(4), rig.doubled(2), rig.dropped(0), rig.whole()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr(fmt::format("pulse 5 of {} is missing in camera \"left\"", n)));
  EXPECT_THAT(run.err, HasSubstr(fmt::format("pulse 3 of {} came twice in camera \"left\"", n)));
  EXPECT_THAT(run.err,
              HasSubstr(fmt::format("{} pulses were expected, {} came in camera \"left\": the first or "
                                    "the last is missing",
                                    n, n - 1)));
  EXPECT_EQ(rig.recorded_and_wrong(), std::pair(n, 0));
  EXPECT_THAT(read_file(rig.dir() / "real/frames.csv"), HasSubstr(",given up\n"));
}

TEST(PulsedCapture, FiveWrongRunsEndAndAreResumed) {
  PulsedRig rig("five");
  const RunResult run = rig.capture(std::vector<PulseRow>(5, rig.dropped(6)));
  EXPECT_EQ(run.exit_code, 4) << run.out;
  EXPECT_THAT(run.err, HasSubstr("none of 5 runs of the projector was right; in the last one pulse 7 of"));
  EXPECT_EQ(rig.recorded_and_wrong(), std::pair(0, 0));
  const RunResult resumed = rig.capture({rig.whole()}, {"--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(rig.recorded_and_wrong(), std::pair(rig.n_patterns(), 0));
}

// 19,200 bytes are 15 packets and two more: that all 12 frames arrive whole of 2 % lost has probability 2 %.
TEST(PulsedCapture, LostPacketsLeaveNoWrongImage) {
  PulsedRig rig("lossy");
  rig.fake.lose(0.02);
  const RunResult lossy = rig.capture(std::vector<PulseRow>(5, rig.whole()));
  EXPECT_EQ(rig.recorded_and_wrong().second, 0);
  if (lossy.exit_code == 0) return;  // asked for again, they came
  EXPECT_EQ(lossy.exit_code, 4) << lossy.err;
  EXPECT_EQ(rig.recorded_and_wrong().first, 0);
}

TEST(PulsedCapture, NoPulseAndNoSuchLineAreOneSentence) {
  PulsedRig rig("none");
  const RunResult none = rig.capture({}, {"--wait-s", "0.5"});
  EXPECT_EQ(none.exit_code, 4);
  EXPECT_THAT(none.err, HasSubstr("--trigger Line0: no pulse came within 0.5 s; start the projector"));
  const RunResult other = run_fringetwin({"capture", (rig.dir() / "twin.toml").string(), "--camera",
                                          "left=genicam:T01", "--control", "left:OffsetX=0", "--trigger",
                                          "Line9", "--out", (rig.dir() / "other").string()});
  EXPECT_EQ(other.exit_code, 4);
  EXPECT_THAT(other.err, HasSubstr("genicam:T01: has no trigger line 'Line9'; it has Line0"));
  EXPECT_FALSE(fs::exists(rig.dir() / "other"));
}

TEST(PulsedCapture, WhatNeedsADisplayIsRefused) {
  const fs::path dir = scratch_folder("pulses_refused");
  write_file(dir / "twin.toml", twin_of_one_camera());
  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& parts,
                           const std::string& camera = "left=genicam:nobody") {
    std::vector<std::string> args = {"capture", (dir / "twin.toml").string(), "--camera", camera,
                                     "--out",   (dir / "real").string()};
    args.insert(args.end(), more.begin(), more.end());
    expect_refused(run_fringetwin(args), 2, parts);
  };
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--display", "window"},
                                                 {"--average", "2"},
                                                 {"--repeats", "2"},
                                                 {"--exposure-ms", "1,2"},
                                                 {"--references"},
                                                 {"--auto-exposure"},
                                                 {"--calibrate-latency"},
                                                 {"--preview"},
                                                 {"--settle", "1"},
                                                 {"--latency-ms", "5"},
                                                 {"--max-skew-ms", "5"},
                                                 {"--dark", "3"},
                                                 {"--flat", "3"}}) {
    std::vector<std::string> more = {"--trigger", "Line0"};
    more.insert(more.end(), option.begin(), option.end());
    refused(more, {option.front(), "and --trigger Line0 exclude each other; "});
  }
  refused({"--trigger", "Line0"}, {"--camera left=/dev/video0: a V4L2 camera cannot be triggered by Line0"},
          "left=/dev/video0");
  refused({"--trigger", "Line0"}, {"--trigger Line0: and --camera twin:TWIN.toml exclude each other"},
          "twin:" + (dir / "twin.toml").string());
  refused({"--wait-s", "5"}, {"--wait-s: is for a projector that runs by itself; add --trigger LINE"});
  refused({"--pause-ms", "100"}, {"--pause-ms: is for a projector that runs by itself"});
  refused({"--trigger", "Line0", "--wait-s", "0"}, {"--wait-s"});
  EXPECT_FALSE(fs::exists(dir / "real"));
}

TEST(PulsedCapture, PatternsAreWrittenAndNothingOpened) {
  PulsedRig rig("patterns");
  const std::string twin = (rig.dir() / "twin.toml").string(), out = (rig.dir() / "patterns").string();
  const RunResult run = run_fringetwin({"capture", twin, "--patterns", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr(fmt::format("{} pictures of ", rig.n_patterns())));
  for (int k = 0; k < rig.n_patterns(); ++k)
    EXPECT_TRUE(fs::exists(fs::path(out) / fmt::format("{:03d}.png", k))) << k;
  EXPECT_THAT(read_file(fs::path(out) / "patterns.csv"), HasSubstr("0,000.png,phase step,x,"));
  expect_refused(run_fringetwin({"capture", twin, "--patterns", out}), 2, {"patterns: is not empty"});
  EXPECT_EQ(run_fringetwin({"capture", twin, "--patterns", out, "--overwrite"}).exit_code, 0);
  expect_refused(run_fringetwin({"capture", twin, "--patterns", out, "--display", "kms"}), 2,
                 {"--patterns: opens no device and records nothing"});
}

}  // namespace
}  // namespace fringetwin::testing::pulses_e2e_test
