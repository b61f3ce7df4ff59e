// SPDX-License-Identifier: Apache-2.0
// Latency found from images of a rig whose latency is known.
//
// | check                        | tolerance                    | origin |
// |------------------------------|------------------------------|---------------------------------------------------|
// | recommended latency          | [true, true + 6 ms]          | 40 changes at random phases of a frame
// of 16.7 ms: the least of 40 delays is 0.4 ms in the mean, above 5 ms once in 1e6; and the margin | | frames
// beginning after it    | none with old light > threshold | what it is for                                 |
#include "capture/adjust/latency.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/capture/even_rig.hpp"
#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/random_values.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::testing::latency_test {
namespace {

using namespace fringetwin::capture;
using testing::EvenCameraOptions;
using testing::EvenRig;
using ::testing::HasSubstr;
using testing::uniform;

class CaptureLatency : public ::testing::Test {
 protected:
  CaptureLatency() { set_quiet(true); }
  ~CaptureLatency() override { set_quiet(false); }

  static std::string refused(EvenRig& rig) {
    try {
      calibrate_latency(rig.cameras, rig.display);
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::device);
      return error.what();
    }
    ADD_FAILURE() << "no UserError";
    return "";
  }
};

TEST_F(CaptureLatency, OfALightThatJumps) {
  EvenRig rig;
  rig.world->latency_ms = 43.0;
  rig.add("left", {});
  rig.add("right", {.offset_ms = 5.0, .exposure_ms = 4.0, .stamped_at_begin = true});
  const Latency latency = calibrate_latency(rig.cameras, rig.display);
  ASSERT_EQ(latency.cameras.size(), 2u);
  for (const CameraLatency& camera : latency.cameras) {
    EXPECT_EQ(camera.changes, 40);
    EXPECT_TRUE(camera.steady);
    const double exposure_ms = camera.camera == "left" ? 10.0 : 4.0;
    EXPECT_GE(camera.begins_ms.min, 43.0 - exposure_ms);
    EXPECT_LE(camera.begins_ms.max, 43.0 + 16.7 - exposure_ms + 0.2);  // 0.02 of an exposure goes unseen
    EXPECT_GE(camera.complete_ms.min, 42.7);  // 0.02 of an exposure of 10 ms goes unseen
    EXPECT_LT(camera.complete_ms.max, 43.0 + 16.7);
    EXPECT_LE(camera.most_mixed, 1);
    EXPECT_EQ(camera.complete_frames.min, 3.0);  // 43 ms / 16.7 ms = 2.6 frames
    EXPECT_EQ(camera.complete_frames.max, 4.0);
  }
  // The third frame begins 33.4 to 50.1 ms after it was shown: its 10 ms nearly always see the light of 43
  // ms.
  EXPECT_EQ(latency.cameras[0].begins_frames.median, 3.0);
  EXPECT_NEAR(latency.cameras[0].black_dn, 4.0, 0.01);
  EXPECT_EQ(latency.settle_frames, 0);
  EXPECT_EQ(latency.settle_without_latency, 3);
  EXPECT_GE(latency.latency_ms, 43.0);
  EXPECT_LE(latency.latency_ms, 43.0 + 6.0);
  EXPECT_THAT(latency.lines().back(), HasSubstr("use --latency-ms 4"));
}

/// Any rig: latency up to many frames, any exposure, brightness, noise, light that creeps, frames that are
/// lost.
RC_GTEST_PROP(CaptureLatencyProperty, NoFrameAfterItShowsOldLight, ()) {
  set_quiet(true);
  EvenRig rig;
  rig.world->random.seed(static_cast<std::uint64_t>(*rc::gen::inRange(0, 1000000)));
  rig.world->latency_ms = *uniform(0.0, 150.0);
  rig.world->rise_ms = *rc::gen::element(0.0, 0.0, 3.0, 25.0);
  EvenCameraOptions camera;
  camera.width = 16;
  camera.height = 12;
  camera.exposure_ms = *uniform(0.5, 16.0);
  camera.bits = *rc::gen::element(8, 12);
  const double top = (1 << camera.bits) - 1;
  // white at the brightest pixel: from a tenth of the range to just below the clip
  camera.dn_per_ms = *uniform(0.1, 0.85) * top / camera.exposure_ms;
  camera.ambient = *rc::gen::element(0.0, 0.05);
  camera.noise_dn = *uniform(0.0, 0.04) * camera.dn_per_ms * camera.exposure_ms;
  camera.stamped_at_begin = *rc::gen::arbitrary<bool>();
  camera.exposure_known = camera.stamped_at_begin || *rc::gen::arbitrary<bool>();
  for (int i = 0; i < 5; ++i) camera.lost.insert(static_cast<std::uint32_t>(*rc::gen::inRange(150, 800)));
  rig.add("left", camera);
  const Latency latency = calibrate_latency(rig.cameras, rig.display);
  set_quiet(false);
  const CameraLatency& found = latency.cameras[0];
  RC_ASSERT(found.changes >= 30);
  // without a known exposure, frames count from their end
  const double end_ms =
      rig.world->latency_ms + rig.world->rise_ms + (camera.exposure_known ? 0.0 : camera.exposure_ms);
  // old light that goes unseen, with noise a threshold and a half e of it: where the light jumps e T of an
  // exposure T; within a rise of R it lies e R + T/2 before the end, near that end sqrt(2 e T R)
  const double e = 1.5 * found.threshold, T = camera.exposure_ms, R = rig.world->rise_ms;
  const double unseen_ms =
      std::max(e * T, R > 0.0 ? std::max(e * R + T / 2.0, std::sqrt(2.0 * e * T * R)) : 0.0);
  RC_ASSERT(found.needed_ms >= end_ms - unseen_ms - 1e-6);
  if (rig.world->rise_ms == 0.0) {
    RC_ASSERT(found.steady);
    RC_ASSERT(latency.latency_ms >= end_ms);
    RC_ASSERT(latency.latency_ms <= end_ms + 6.0 + found.threshold * 16.7);
  }
}

TEST_F(CaptureLatency, ScatterIsSeenAndTheLongestCounts) {
  EvenRig rig;
  rig.world->jitter_ms = 40.0;
  rig.world->timed = false;
  rig.add("left", {});
  const Latency latency = calibrate_latency(rig.cameras, rig.display, {.changes = 100});
  EXPECT_FALSE(latency.cameras[0].steady);
  EXPECT_EQ(latency.settle_frames, 1);
  EXPECT_GT(latency.latency_ms, 20.0 + 37.0);  // the longest of 100 is within 3 ms of 40 but for 5e-4
  EXPECT_LT(latency.latency_ms, 20.0 + 40.0 + 16.7 + 1.0);
}

TEST_F(CaptureLatency, NoiseAsGreatAsTheLightIsAveragedOverThePixels) {
  EvenRig rig;
  rig.add("left",
          {.width = 128, .height = 96, .bits = 12, .black_dn = 100.0, .dn_per_ms = 3.0, .noise_dn = 20.0});
  const Latency latency = calibrate_latency(rig.cameras, rig.display);
  EXPECT_GE(latency.latency_ms, 20.0);
  EXPECT_LE(latency.latency_ms, 20.0 + 6.0 + latency.cameras[0].threshold * 16.7);
}

TEST_F(CaptureLatency, WhatHindersItIsSaid) {
  {
    EvenRig rig;
    rig.world->lamp_on = false;
    rig.add("left", {.noise_dn = 1.0});
    EXPECT_THAT(refused(rig),
                ::testing::AllOf(
                    HasSubstr("camera \"left\": sees no change between the projector's black and white ("),
                    HasSubstr("is it on")));
  }
  {
    EvenRig rig;
    rig.add("left", {.dn_per_ms = 1000.0});
    EXPECT_THAT(refused(rig), HasSubstr("is saturated wherever"));
  }
  {
    EvenRig rig;
    rig.world->level = 1.0;  // what is called black gives light, white takes it away
    rig.add("left", {.black_dn = 200.0, .dn_per_ms = -15.0});
    EXPECT_THAT(refused(rig), HasSubstr("white darker than its black"));
  }
  {
    EvenRig rig;
    EvenCameraOptions camera;
    for (std::uint32_t i = 200; i < 20000; i += 2) camera.lost.insert(i);
    rig.add("left", camera);
    EXPECT_THAT(refused(rig), HasSubstr("of 40 changes between black and white whole"));
  }
}

}  // namespace
}  // namespace fringetwin::testing::latency_test
