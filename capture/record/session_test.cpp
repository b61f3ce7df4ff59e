// SPDX-License-Identifier: Apache-2.0
// The recording on cameras that see the projector's picture pixel for pixel, with every fault.
#include "capture/record/session.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "capture/record/verify_set.hpp"
#include "tests/support/capture/loop_rig.hpp"
#include "tests/support/twin/child_process.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::session_test {
namespace {

using namespace fringetwin::capture;
using ::testing::HasSubstr;
using testing::loop_twin;
using testing::LoopFault;
using testing::LoopRig;
namespace fs = std::filesystem;

class Session : public ::testing::Test {
 protected:
  Session() { set_quiet(true); }
  ~Session() override { set_quiet(false); }

  CapturePlan plan_for_loop() const {
    CapturePlan plan;
    plan.settle_frames = 0;
    plan.latency_ms = 15.0;  // LoopWorld's
    plan.timeout = std::chrono::milliseconds(200);
    return plan;
  }

  SessionSummary record(const Twin& twin, LoopRig& rig, const CapturePlan& plan,
                        Existing existing = Existing::refuse) {
    Recording recording(scratch_ / "set", twin, plan, recording_identity(twin, rig.cameras, plan), existing);
    return record_session(twin, rig.cameras, *rig.display, plan, recording, {});
  }

  /// Every image is the projected pattern in the camera's 8 bit.
  void expect_whole(const Twin& twin, const std::string& set = "") {
    const SetCheck check = verify_set(scratch_ / "set", &twin);
    EXPECT_THAT(check.findings, ::testing::IsEmpty());
    for (const Pattern& pattern : sequence_patterns(twin.fringes))
      for (const Camera& camera : twin.cameras) {
        const auto file = Picture{set, fmt::format("{:04d}", pattern.index)}.file(camera.name);
        const ImageF image = read_gray(scratch_ / "set" / file).image;
        const ImageU16 projected = quantise_levels(pattern_levels(twin.fringes, pattern, 64, 48), 8);
        ASSERT_EQ(image.size(), projected.size());
        for (std::size_t i = 0; i < image.size(); ++i)
          ASSERT_EQ(image.data[i], static_cast<float>(projected.data[i])) << file << " pixel " << i;
      }
  }

  testing::ScratchFolder scratch_;
};

TEST_F(Session, RecordsEveryPatternBitExactly) {
  const Twin twin = loop_twin(2);
  LoopRig rig(twin);
  const SessionSummary summary = record(twin, rig, plan_for_loop());
  EXPECT_EQ(summary.recorded, 8);
  EXPECT_EQ(summary.lost_frames, 0u);
  EXPECT_EQ(summary.retries, 0);
  EXPECT_NEAR(summary.worst_skew_ms, 3.0, 1e-9);  // the loop's offset
  expect_whole(twin);
  EXPECT_FALSE(fs::exists(scratch_ / "set" / kJournalName));
}

// Without the latency a frame of the pattern before would be taken: the test above would not see it
// otherwise.
TEST_F(Session, TooEarlyFramesWouldShowThePatternBefore) {
  const Twin twin = loop_twin(1);
  LoopRig rig(twin);
  CapturePlan plan = plan_for_loop();
  plan.latency_ms = 0.0;
  record(twin, rig, plan);
  const ImageF second = read_gray(scratch_ / "set" / "left/0001.png").image;
  const ImageU16 first =
      quantise_levels(pattern_levels(twin.fringes, sequence_patterns(twin.fringes)[0], 64, 48), 8);
  EXPECT_TRUE(std::equal(second.data.begin(), second.data.end(), first.data.begin(),
                         [](float a, std::uint16_t b) { return a == static_cast<float>(b); }));
}

TEST_F(Session, SettlingFramesStandInForTheLatency) {
  const Twin twin = loop_twin(1);
  LoopRig rig(twin);
  CapturePlan plan = plan_for_loop();
  plan.latency_ms = 0.0;
  plan.settle_frames = 2;
  record(twin, rig, plan);
  expect_whole(twin);
}

TEST_F(Session, LostRepeatedAndCorruptFramesAreCountedAndReplaced) {
  const Twin twin = loop_twin(2);
  LoopRig rig(twin);
  CapturePlan plan = plan_for_loop();
  plan.average = 3;
  rig.world->faults = {{5, LoopFault::lost},
                       {11, LoopFault::error_flag},
                       {26, LoopFault::repeated},
                       {27, LoopFault::repeated},
                       {40, LoopFault::error_flag}};
  const SessionSummary summary = record(twin, rig, plan);
  EXPECT_EQ(summary.lost_frames, 1u);
  EXPECT_EQ(summary.corrupt_frames, 2);
  EXPECT_EQ(summary.repeated_frames, 2);
  expect_whole(twin);
  const std::string frames = testing::read_file(scratch_ / "set/frames.csv");
  EXPECT_THAT(frames, HasSubstr("error flag"));
  EXPECT_THAT(frames, HasSubstr("repeated"));
  EXPECT_THAT(frames, HasSubstr("0x40"));
}

// Frames of a try that came to nothing went into no image.
TEST_F(Session, FramesCsvNamesWhatWentIntoEachImage) {
  const Twin twin = loop_twin(2);
  LoopRig rig(twin);
  CapturePlan plan = plan_for_loop();
  plan.average = 3;
  rig.world->faults = {{8, LoopFault::stream}, {30, LoopFault::timeout}};
  EXPECT_EQ(record(twin, rig, plan).retries, 2);
  std::istringstream frames(testing::read_file(scratch_ / "set/frames.csv"));
  std::map<std::string, int> used;
  int given_up = 0;
  for (std::string line; std::getline(frames, line);) {
    std::vector<std::string> fields;
    std::istringstream row(line);
    for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
    ASSERT_EQ(fields.size(), 9u) << line;
    given_up += fields[8] == "given up" ? 1 : 0;
    if (fields[8].starts_with("000")) ++used[fields[4] + fields[8]];
  }
  EXPECT_EQ(used.size(), 16u);
  for (const auto& [image, n] : used) EXPECT_EQ(n, 3) << image;
  EXPECT_GT(given_up, 0);
}

// Two free-running cameras of which one loses every fifth frame: its later frames are still near to some of
// the other's.
TEST_F(Session, LostFramesDoNotDriveTheCamerasApart) {
  const Twin twin = loop_twin(2);
  LoopRig rig(twin);
  CapturePlan plan = plan_for_loop();
  plan.average = 20;
  plan.attempts = 20;
  for (int call = 3; call < 1000; call += 10) rig.world->faults[call] = LoopFault::lost;
  const SessionSummary summary = record(twin, rig, plan);
  EXPECT_EQ(summary.retries, 0);
  EXPECT_GT(summary.lost_frames, 10u);
  EXPECT_LE(summary.worst_skew_ms, 5.0 + 1e-9);  // half a period
  expect_whole(twin);
}

// With several frames of each image the leader has some before and some behind: the nearest is 3 ms away.
TEST_F(Session, TheSkewIsThatToTheNearestFrameOnEitherSide) {
  const Twin twin = loop_twin(2);
  LoopRig rig(twin);
  CapturePlan plan = plan_for_loop();
  plan.average = 3;
  EXPECT_NEAR(record(twin, rig, plan).worst_skew_ms, 3.0, 1e-9);
}

TEST_F(Session, CamerasTooFarApartAreAFault) {
  const Twin twin = loop_twin(2);
  LoopRig rig(twin);
  CapturePlan plan = plan_for_loop();
  plan.max_skew_ms = 2.9;  // the loop's cameras are 3 ms apart
  try {
    record(twin, rig, plan);
    FAIL();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("frames are 3.00 ms apart, more than the 2.90 ms allowed"));
  }
}

TEST_F(Session, AnExposureTheCameraCannotTakeIsRefused) {
  const Twin twin = loop_twin(1);
  LoopRig rig(twin);
  rig.world->exposure_step_ms = 0.1;
  CapturePlan plan = plan_for_loop();
  plan.exposures_ms = {0.25};
  try {
    record(twin, rig, plan);
    FAIL();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot be exposed for 0.25 ms, the nearest is 0.3"));
  }
  plan.exposures_ms = {0.3};
  record(twin, rig, plan, Existing::overwrite);
  expect_whole(twin);
}

// Drivers pass an exposure on some frames late; four of them are no image of the set. The light comes at once
// here, so that no latency hides them.
TEST_F(Session, FramesOfTheExposureBeforeAreLeftOut) {
  const Twin twin = loop_twin(2);
  LoopRig rig(twin);
  rig.world->latency_ms = 0.0;
  rig.world->exposure_step_ms = 0.1;
  rig.world->exposure_late_frames = 4;
  CapturePlan plan = plan_for_loop();
  plan.latency_ms = 0.0;
  plan.exposures_ms = {0.3};
  record(twin, rig, plan);
  expect_whole(twin);
}

TEST_F(Session, BrokenStreamsTimeoutsAndLostSignalsAreTriedAgain) {
  for (const LoopFault fault : {LoopFault::stream, LoopFault::timeout, LoopFault::no_signal}) {
    const Twin twin = loop_twin(2);
    LoopRig rig(twin);
    rig.world->faults = {{7, fault}};
    const SessionSummary summary = record(twin, rig, plan_for_loop(), Existing::overwrite);
    EXPECT_EQ(summary.retries, 1) << static_cast<int>(fault);
    expect_whole(twin);
  }
}

TEST_F(Session, AFaultThatStaysEndsWithASentenceAndResumes) {
  const Twin twin = loop_twin(1);
  LoopRig rig(twin);
  for (int call = 9; call < 60; ++call) rig.world->faults[call] = LoopFault::timeout;
  try {
    record(twin, rig, plan_for_loop());
    FAIL() << "the fault stays";
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    EXPECT_THAT(error.what(), HasSubstr("no frame for 2000 ms"));
    EXPECT_THAT(error.what(), HasSubstr("of 8 patterns are kept, go on with --resume"));
  }
  rig.world->faults.clear();
  record(twin, rig, plan_for_loop(), Existing::resume);
  expect_whole(twin);
}

TEST_F(Session, AnUnpluggedCameraLosesNothing) {
  const Twin twin = loop_twin(2);
  LoopRig rig(twin);
  rig.world->faults = {{20, LoopFault::gone}};
  EXPECT_THROW(record(twin, rig, plan_for_loop()), UserError);
  EXPECT_FALSE(fs::exists(scratch_ / "set" / "capture.toml"));
  const SetCheck unfinished = verify_set(scratch_ / "set");
  EXPECT_FALSE(unfinished.passed());
  EXPECT_TRUE(unfinished.unfinished);
  LoopRig again(twin);
  const SessionSummary summary = record(twin, again, plan_for_loop(), Existing::resume);
  EXPECT_LT(summary.recorded, 8);
  EXPECT_GT(summary.recorded, 0);
  expect_whole(twin);
}

TEST_F(Session, RepeatsAreSetsOfTheirOwn) {
  const Twin twin = loop_twin(1);
  LoopRig rig(twin);
  CapturePlan plan = plan_for_loop();
  plan.repeats = 3;
  plan.references = true;
  plan.dark_frames = 2;
  plan.flat_frames = 2;
  record(twin, rig, plan);
  for (const std::string set : {"", "repeat_01", "repeat_02"}) expect_whole(twin, set);
  for (const std::string file : {"dark/left/0001.png", "left/black.png"})
    EXPECT_EQ(read_gray(scratch_ / "set" / file).image(5, 5), 0.0f) << file;
  for (const std::string file : {"flat/left/0001.png", "repeat_02/left/white.png"})
    EXPECT_EQ(read_gray(scratch_ / "set" / file).image(5, 5), 255.0f) << file;
}

TEST_F(Session, AnotherPlanOrAFinishedSetIsNotResumed) {
  const Twin twin = loop_twin(1);
  LoopRig rig(twin);
  const CapturePlan plan = plan_for_loop();
  rig.world->faults = {{9, LoopFault::gone}};
  EXPECT_THROW(record(twin, rig, plan), UserError);
  CapturePlan other = plan;
  other.average = 2;
  const auto sentence = [&](const CapturePlan& with, Existing existing) -> std::string {
    try {
      LoopRig again(twin);
      record(twin, again, with, existing);
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(sentence(other, Existing::resume), HasSubstr("begun with average = 1, now it is 2"));
  EXPECT_THAT(sentence(plan, Existing::refuse), HasSubstr("unfinished recording; go on with --resume"));
  EXPECT_EQ(sentence(plan, Existing::resume), "");
  EXPECT_THAT(sentence(plan, Existing::refuse), HasSubstr("holds a capture set already"));
  EXPECT_THAT(sentence(other, Existing::resume), HasSubstr("complete set recorded otherwise"));
  EXPECT_EQ(sentence(other, Existing::overwrite), "");
  expect_whole(twin);
}

TEST_F(Session, AJournalCutShortAndADamagedImageAreRecordedAgain) {
  const Twin twin = loop_twin(1);
  LoopRig rig(twin);
  rig.world->faults = {{20, LoopFault::gone}};
  EXPECT_THROW(record(twin, rig, plan_for_loop()), UserError);
  const fs::path journal = scratch_ / "set" / kJournalName;
  fs::resize_file(journal, fs::file_size(journal) - 7);
  scratch_.write("set/left/0001.png", "half an image");
  LoopRig again(twin);
  record(twin, again, plan_for_loop(), Existing::resume);
  expect_whole(twin);
}

TEST_F(Session, ACameraNamedLikeASetIsRefusedBeforeAnythingIsWritten) {
  Twin twin = loop_twin(1);
  twin.cameras[0].name = "repeat_01";
  LoopRig rig(twin);
  EXPECT_THROW(record(twin, rig, plan_for_loop()), UserError);
  EXPECT_FALSE(fs::exists(scratch_ / "set"));
}

TEST_F(Session, DevicesThatDoNotFitAreRefused) {
  const Twin twin = loop_twin(1);
  LoopRig rig(twin);
  const auto sentence = [&](const Twin& other) -> std::string {
    try {
      check_rig(other, rig.cameras, *rig.display, plan_for_loop());
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(sentence(twin), "");
  Twin larger = twin;
  larger.cameras[0].lens = Lens("LENSMODEL_PINHOLE", {100, 100, 39.5, 23.5}, {80, 48}, "test");
  EXPECT_THAT(sentence(larger), HasSubstr("delivers 64 x 48 px, camera \"left\" of the twin has 80 x 48"));
  Twin wide = twin;
  wide.projector->lens = larger.cameras[0].lens;
  EXPECT_THAT(sentence(wide), HasSubstr("shows 64 x 48 px, the twin's projector has 80 x 48"));
  rig.cameras[0].stored_bits = 12;
  EXPECT_THAT(sentence(twin), HasSubstr("delivers 8 bit, the twin has bit_depth = 12"));
}

}  // namespace
}  // namespace fringetwin::testing::session_test
