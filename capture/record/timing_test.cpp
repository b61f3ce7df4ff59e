// SPDX-License-Identifier: Apache-2.0
// What a recording takes and whether exposures hold whole frames: numbers by hand, exact but for the last
// binary digits (1e-9).
#include "capture/record/timing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/capture/loop_rig.hpp"

namespace fringetwin::testing::timing_test {
namespace {

using namespace fringetwin::capture;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

Step step_of(int pictures, int average, std::optional<double> exposure_ms = std::nullopt) {
  return {even_field(1.0, "white"), exposure_ms, average, true,
          std::vector<Picture>(static_cast<std::size_t>(pictures))};
}
CameraTiming triggered(std::optional<double> exposure_ms) {
  return {"left", exposure_ms, std::nullopt, true};
}
CameraTiming free_running(std::optional<double> exposure_ms, std::optional<double> period_ms) {
  return {"right", exposure_ms, period_ms, false};
}

TEST(CaptureTiming, LeastTimeOfARecording) {
  CapturePlan plan;
  plan.settle_frames = 2;
  plan.latency_ms = 30.0;
  const std::vector<Step> steps(10, step_of(1, 4));
  // 4 frames and 2 that settle, of 10 ms, and the latency, ten times
  EXPECT_NEAR(least_seconds({{}, {triggered(10.0)}}, steps, plan).value(), 0.9, 1e-9);
  // the next frame is half a period away; the slower camera counts
  EXPECT_NEAR(least_seconds({{}, {triggered(10.0), free_running(5.0, 20.0)}}, steps, plan).value(), 1.6,
              1e-9);
  EXPECT_NEAR(least_seconds({{}, {free_running(40.0, 20.0)}}, steps, plan).value(), 2.9, 1e-9);
  EXPECT_NEAR(least_seconds({{}, {free_running({}, 20.0)}}, steps, plan).value(), 1.6, 1e-9);
  EXPECT_FALSE(least_seconds({{}, {triggered(10.0), triggered({})}}, steps, plan));
  // three images of a pattern, each of four frames, at an exposure of the step's own
  EXPECT_NEAR(least_seconds({{}, {triggered(10.0)}}, {step_of(3, 4, 100.0)}, plan).value(), 1.43, 1e-9);
  EXPECT_EQ(plan_text({{}, {triggered(10.0)}}, steps, plan),
            "10 patterns, 40 frames of each camera: 0.9 s at least");
  EXPECT_EQ(plan_text({{}, {triggered({})}}, steps, plan), "10 patterns, 40 frames of each camera");
}

TEST(CaptureTiming, ShareOfLightThatMayDiffer) {
  EXPECT_NEAR(flicker_share(20.0, 20.0), 0.0, 1e-9);
  EXPECT_NEAR(flicker_share(60.0, 20.0), 0.0, 1e-9);
  EXPECT_NEAR(flicker_share(50.0, 20.0), 0.2, 1e-9);  // half a frame of two and a half
  EXPECT_NEAR(flicker_share(45.0, 20.0), 1.0 / 9.0, 1e-9);
  EXPECT_NEAR(flicker_share(10.0, 20.0), 1.0, 1e-9);  // half a frame: all of its light, or none
}

TEST(CaptureTiming, ExposuresThatAreNoWholeFramesAreWarnedOf) {
  const RigTiming rig{1000.0 / 60.0, {triggered(10.0), free_running(1000.0 / 30.0, 40.0)}};
  const auto warnings = flicker_warnings(rig, {});
  ASSERT_THAT(warnings, SizeIs(1));
  EXPECT_THAT(warnings[0],
              AllOf(HasSubstr("camera \"left\": an exposure of 10 ms is 0.6 frames of the projector"),
                    HasSubstr("by up to 67 % from image to image: expose for 16.6667 ms")));
  EXPECT_THAT(flicker_warnings(rig, {1000.0 / 60.0, 50.0}), IsEmpty());
  EXPECT_THAT(flicker_warnings(rig, {16.667, 25.0}), SizeIs(2));  // one for each camera
  // A camera's step, and 59.94 Hz for 60, are below what a gray value shows.
  EXPECT_THAT(flicker_warnings({16.6833, {triggered(16.667)}}, {}), IsEmpty());
  EXPECT_THAT(flicker_warnings({std::nullopt, {triggered(10.0)}}, {}), IsEmpty());
  EXPECT_THAT(flicker_warnings({16.7, {triggered({})}}, {}), IsEmpty());
}

TEST(CaptureTiming, IsWhatTheDevicesSay) {
  const Twin twin = loop_twin(2, 8);
  LoopRig rig(twin);
  DisplayInfo display = rig.display->info();
  display.frame_ms = 16.0;
  const RigTiming timing = rig_timing(rig.cameras, display, std::nullopt);
  EXPECT_EQ(timing.projector_frame_ms, 16.0);
  EXPECT_EQ(rig_timing(rig.cameras, display, 8.0).projector_frame_ms, 8.0);
  ASSERT_THAT(timing.cameras, SizeIs(2));
  EXPECT_EQ(timing.cameras[1].name, twin.cameras[1].name);
  EXPECT_EQ(timing.cameras[1].period_ms, rig.cameras[1].device->info().period_ms);
}

}  // namespace
}  // namespace fringetwin::testing::timing_test
