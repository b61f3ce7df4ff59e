// SPDX-License-Identifier: Apache-2.0
// The recording that a projector leads, on cameras whose runs the test makes: a wrong run leaves no image,
// the next right one all of them.
#include "capture/record/pulse_session.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/record/verify_set.hpp"
#include "tests/support/capture/loop_rig.hpp"
#include "tests/support/capture/pulsed_camera.hpp"
#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/expect_user_error.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::pulse_session_test {
namespace {

using namespace fringetwin::capture;
using namespace std::chrono_literals;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr TimeNs kIntervalNs = 20'000'000;

class PulseRecording : public ::testing::Test {
 protected:
  PulseRecording() { set_quiet(true); }
  ~PulseRecording() override { set_quiet(false); }

  /// A whole run: what is seen of each pattern, `lift` gray values brighter than shown.
  PulsedRun run(int lift = 0) {
    PulsedRun made;
    for (const Pattern& pattern : sequence_patterns(twin_.fringes)) {
      Frame frame;
      frame.dn = shown(pattern, lift);
      frame.sequence = ++block_;
      frame.camera_ns = 1'000'000'000 + static_cast<TimeNs>(made.size()) * kIntervalNs;
      frame.timestamp_ns = 5'000'000 + frame.camera_ns;
      made.push_back({frame, std::nullopt});
    }
    return made;
  }
  ImageU16 shown(const Pattern& pattern, int lift) const {
    ImageU16 dn = quantise_levels(pattern_levels(twin_.fringes, pattern, 64, 48), 8);
    for (std::uint16_t& value : dn.data) value = static_cast<std::uint16_t>(std::min(value + lift, 255));
    return dn;
  }
  PulsedRun without(PulsedRun all, std::ptrdiff_t k) const {
    all.erase(all.begin() + k);
    for (std::size_t i = 0; i < all.size(); ++i)  // the camera counts frames, no pulses
      all[i].frame.sequence = 100 + static_cast<std::uint32_t>(i);
    return all;
  }

  /// By camera.
  Rig rig(std::vector<std::deque<PulsedRun>> runs) const {
    Rig made;
    for (std::size_t c = 0; c < runs.size(); ++c)
      made.push_back({twin_.cameras[c].name, 8, std::make_unique<PulsedCamera>(64, 48, std::move(runs[c]))});
    return made;
  }
  SessionSummary record(const Rig& rig, Existing existing = Existing::refuse) {
    Recording recording(dir(), twin_, plan_, recording_identity(twin_, rig, plan_), existing);
    return record_pulses(twin_, rig, plan_, options_, recording, {});
  }

  fs::path dir() const { return scratch_ / "set"; }
  bool has_images() const { return fs::exists(dir() / "left/0000.png"); }
  void expect_whole(int lift = 0) {
    EXPECT_THAT(verify_set(dir(), &twin_).findings, IsEmpty());
    EXPECT_FALSE(fs::exists(dir() / kJournalName));
    for (const Pattern& pattern : sequence_patterns(twin_.fringes))
      for (const Camera& camera : twin_.cameras) {
        const auto file = Picture{"", fmt::format("{:04d}", pattern.index)}.file(camera.name);
        const ImageF image = read_gray(dir() / file).image;
        const ImageU16 expected = shown(pattern, lift);
        ASSERT_TRUE(std::ranges::equal(image.data, expected.data)) << file;
      }
  }
  std::string frames_csv() const { return read_file(dir() / "frames.csv"); }

  Twin twin_ = loop_twin(1);
  CapturePlan plan_;
  PulseOptions options_{.wait = 100ms, .pause = 20ms};
  std::uint32_t block_ = 0;
  ScratchFolder scratch_;
};

TEST_F(PulseRecording, EachPulseIsItsPattern) {
  const SessionSummary summary = record(rig({{run()}}));
  EXPECT_EQ(summary.recorded, 8);
  EXPECT_EQ(summary.retries, 0);
  expect_whole();
  // the number of the run, the camera's own clock, the image
  EXPECT_THAT(frames_csv(), HasSubstr("1,x pitch 13 step 2/4,1025000000,1,left,2,1020000000,0x0,0001\n"));
  const std::string toml = read_file(dir() / "capture.toml");
  EXPECT_THAT(toml, HasSubstr("\"device projector\" = \"a projector that runs by itself\""));
  EXPECT_THAT(toml, HasSubstr("\"projector timing\" = \"its pulses\""));
}

TEST_F(PulseRecording, ARunThatMemoryDoesNotHoldIsRefusedBeforeItBegins) {
  Rig large;
  large.push_back({twin_.cameras[0].name, 8,
                   std::make_unique<PulsedCamera>(2'000'000, 2'000'000, std::deque<PulsedRun>{run()})});
  expect_user_error(ExitCode::device,
                    "a run of 8 images of each camera is held in memory until it is judged: 64000.0 GB",
                    [&] { record(large); });
  EXPECT_FALSE(has_images());
}

// Each pulse is then a run of its own.
TEST_F(PulseRecording, PulsesFurtherApartThanThePauseAreToldSo) {
  const auto one = [&] { return PulsedRun{run().front()}; };
  expect_user_error(ExitCode::device,
                    "one pulse came, and none within 20 ms after it (--pause-ms, which must be longer", [&] {
                      record(rig({{one(), one(), one(), one(), one(), one()}}));
                    });
}

TEST_F(PulseRecording, ADeadLineIsSaidFirst) {
  twin_ = loop_twin(2);
  std::deque<PulsedRun> holes;
  for (int i = 0; i < 6; ++i) holes.push_back(without(without(without(without(run(), 5), 4), 3), 2));
  expect_user_error(ExitCode::device, "in the last one none of 8 pulses came in camera \"right\"", [&] {
    record(rig({holes, {}}));
  });
}

TEST_F(PulseRecording, TwoCamerasArePairedByNumber) {
  twin_ = loop_twin(2);
  PulsedRun right = run();
  for (PulsedFrame& pulsed : right) pulsed.frame.camera_ns += 77'000'000'000;  // another clock
  right[3].frame.camera_ns += 400'000;
  const SessionSummary summary = record(rig({{run()}, {right}}));
  EXPECT_NEAR(summary.worst_skew_ms, 0.4 * 7.0 / 8.0, 0.4 * 0.02);  // the line through 8 takes the rest
  expect_whole();
}

TEST_F(PulseRecording, AWrongRunIsThrownAwayAndTheNextTaken) {
  PulsedRun twice = run(7);
  twice.insert(twice.begin() + 3, twice[2]);
  twice[3].frame.camera_ns += 1'000'000;
  PulsedRun damaged = run(8);
  damaged[5].frame.fault = FrameFault::missing_packets;
  damaged[5].frame.dn = {};
  const SessionSummary summary = record(rig({{without(run(5), 4), twice, damaged, run(6)}}));
  EXPECT_EQ(summary.retries, 3);
  EXPECT_EQ(summary.lost_frames, 1u);
  EXPECT_EQ(summary.repeated_frames, 1);
  EXPECT_EQ(summary.corrupt_frames, 1);
  expect_whole(6);
  const std::string csv = frames_csv();
  EXPECT_THAT(csv, HasSubstr(",given up\n"));
  EXPECT_THAT(csv, HasSubstr(",doubled\n"));
  EXPECT_THAT(csv, HasSubstr(",missing packets\n"));
  EXPECT_THAT(csv, ContainsRegex("x pitch 13 step 1/4,[0-9]+,4,left,[0-9]+,1000000000,0x0,0000\n"));
  EXPECT_THAT(read_file(dir() / "capture.toml"), HasSubstr("\"frames lost\" = \"1\""));
}

TEST_F(PulseRecording, FiveWrongRunsEndWithThePulseAndNoImage) {
  std::deque<PulsedRun> wrong;
  for (int i = 0; i < 6; ++i) wrong.push_back(without(run(), 4));
  expect_user_error(
      ExitCode::device,
      "--trigger Line0: none of 5 runs of the projector was right; in the last one pulse 5 of 8 is "
      "missing in camera \"left\"; give the cameras time between two pulses",
      [&] { record(rig({wrong})); });
  EXPECT_FALSE(has_images());
  EXPECT_FALSE(fs::exists(dir() / "capture.toml"));
  record(rig({{run(3)}}), Existing::resume);
  expect_whole(3);
}

TEST_F(PulseRecording, APulseMissingInOneOfTwoCamerasCostsBothTheRun) {
  twin_ = loop_twin(2);
  const SessionSummary summary = record(rig({{run(4), run()}, {without(run(4), 2), run()}}));
  EXPECT_EQ(summary.retries, 1);
  expect_whole();
}

TEST_F(PulseRecording, NoPulseIsOneSentence) {
  expect_user_error(ExitCode::device, "--trigger Line0: no pulse came within 0.1 s; start the projector",
                    [&] { record(rig({{}})); });
  twin_ = loop_twin(2);
  options_.wait = 60s;
  plan_.attempts = 1;
  expect_user_error(ExitCode::device, "none of 8 pulses came in camera \"right\"", [&] {
    record(rig({{run()}, {}}), Existing::overwrite);
  });
}

TEST_F(PulseRecording, AProjectorThatNeverRestsIsToldSo) {
  PulsedRun endless;
  for (int i = 0; i < 5; ++i) {
    const PulsedRun next = run();
    endless.insert(endless.end(), next.begin(), next.end());
  }
  expect_user_error(ExitCode::device, "more than 26 pulses came without a pause of 20 ms, the sequence has 8",
                    [&] { record(rig({{endless}})); });
  EXPECT_FALSE(has_images());
}

TEST_F(PulseRecording, ABrokenStreamCostsTheRun) {
  PulsedRun broken = run(5);
  broken[3].fault = DeviceFault::Kind::stream;
  EXPECT_EQ(record(rig({{broken, run()}})).retries, 1);
  expect_whole();
  PulsedRun gone = run(5);
  gone[3].fault = DeviceFault::Kind::gone;
  expect_user_error(ExitCode::device, "pulsed: it fails; take the next run with --resume", [&] {
    record(rig({{gone, run()}}), Existing::overwrite);
  });
  EXPECT_FALSE(has_images());
}

// Killed between two images, or with one damaged since: images of two runs do not make a set.
TEST_F(PulseRecording, AResumedRecordingIsOfOneRun) {
  const Rig first = rig({{run(9)}});
  {
    Recording recording(dir(), twin_, plan_, recording_identity(twin_, first, plan_), Existing::refuse);
    const std::vector<Step> steps = make_steps(twin_.fringes, plan_);
    for (int k = 0; k < 3; ++k) {
      StepRecord record;
      record.step = k;
      record.pattern = steps[static_cast<std::size_t>(k)].pattern.label;
      record.shown = {1, 1, false};
      ImageF image(64, 48);
      recording.store(record, {{fmt::format("left/{:04d}.png", k), 8, image}});
    }
    recording.flush();
  }
  const SessionSummary summary = record(rig({{run(2)}}), Existing::resume);
  EXPECT_EQ(summary.recorded, 8);
  expect_whole(2);
  EXPECT_THAT(frames_csv(), HasSubstr(",2,left,"));  // the recording's second run
}

TEST_F(PulseRecording, ACameraWithoutAClockIsJudgedByArrival) {
  PulsedRun plain = run();
  for (PulsedFrame& pulsed : plain) pulsed.frame.camera_ns = 0;
  record(rig({{plain}}));
  expect_whole();
  EXPECT_THAT(frames_csv(), HasSubstr(",1025000000,0x0,0001\n"));
}

TEST_F(PulseRecording, TheExposureIsSetOnceAndExactly) {
  plan_.exposures_ms = {3.0};
  record(rig({{run()}}));
  EXPECT_THAT(read_file(dir() / "capture.toml"), HasSubstr("\"exposure_ms left\" = \"3\""));
  plan_.exposures_ms = {3.4};
  expect_user_error(ExitCode::device, "cannot be exposed for 3.4 ms, the nearest is 3 ms",
                    [&] { record(rig({{run()}}), Existing::overwrite); });
}

TEST_F(PulseRecording, WhatNeedsADisplayIsRefused) {
  const auto refused = [](const std::string& option, const auto& ask) {
    CapturePlan plan;
    ask(plan);
    expect_user_error(ExitCode::usage, option + ": and --trigger Line0 exclude each other; ",
                      [&] { check_pulse_plan(plan, "Line0"); });
  };
  refused("--average", [](CapturePlan& plan) { plan.average = 2; });
  refused("--repeats", [](CapturePlan& plan) { plan.repeats = 2; });
  refused("--exposure-ms with several exposures", [](CapturePlan& plan) { plan.exposures_ms = {1.0, 2.0}; });
  refused("--references", [](CapturePlan& plan) { plan.references = true; });
  refused("--dark", [](CapturePlan& plan) { plan.dark_frames = 1; });
  refused("--flat", [](CapturePlan& plan) { plan.flat_frames = 1; });
  refused("--latency-ms", [](CapturePlan& plan) { plan.latency_ms = 1.0; });
  refused("--max-skew-ms", [](CapturePlan& plan) { plan.max_skew_ms = 1.0; });
  CapturePlan plan;
  plan.exposures_ms = {2.0};
  EXPECT_NO_THROW(check_pulse_plan(plan, "Line0"));
}

}  // namespace
}  // namespace fringetwin::testing::pulse_session_test
