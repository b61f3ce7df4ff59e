// SPDX-License-Identifier: Apache-2.0
// The simulated rig's clock and light: latency, mixed frames, exposure, noise that a resumed run repeats.
#include "capture/rehearse/simulated_rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/capture/loop_rig.hpp"

namespace fringetwin::testing::simulated_rig_test {
namespace {

using namespace fringetwin::capture;
using testing::loop_twin;
using namespace std::chrono_literals;

/// A plane right in front of a 64 x 48 rig.
Twin plane_twin() {
  Twin twin = loop_twin(1, 12);
  twin.projector->intensity = 10.0;
  twin.projector->T_proj_world.translation_mm = {-20.0, 0.0, 0.0};
  twin.cameras[0].sensor.gain_dn = 300.0;
  twin.cameras[0].sensor.black_level_dn = 20.0;
  Object object{"plane", PlaneShape{{0, 0, 400}, {0, 0, -1}, std::nullopt}, Material()};
  twin.objects.push_back(object);
  return twin;
}

class SimulatedRigTest : public ::testing::Test {
 protected:
  SimulatedRig rig(const Twin& twin, const SimulatedOptions& options = {}) {
    return SimulatedRig(twin, render::choose_sampling(twin), renderer_, options);
  }
  static double mean(const ImageU16& image) {
    return std::accumulate(image.data.begin(), image.data.end(), 0.0) / static_cast<double>(image.size());
  }
  /// The first frame after `n` others.
  static Frame frame_after(CameraDevice& camera, int n) {
    for (int i = 0; i < n; ++i) camera.next_frame(1s, CameraDevice::Pixels::drop);
    return camera.next_frame(1s, CameraDevice::Pixels::keep);
  }
  render::Renderer renderer_;
};

// White comes on 20 ms after show(): of 60 Hz frames exposed for 10 ms, [0, 10) and [16.67, 26.67) ..., the
// second is lit for 6.67 ms of its 10.
TEST_F(SimulatedRigTest, ALateLightMixesInProportionToTime) {
  const SimulatedRig devices = rig(plane_twin());
  const auto camera = devices.camera(0);
  const auto display = devices.display();
  camera->start();
  display->show(even_field(0.0, "black"), {});
  const double black = mean(frame_after(*camera, 3).dn);
  const TimeNs shown = display->show(even_field(1.0, "white"), {}).at_ns;
  std::vector<Frame> frames;
  for (int i = 0; i < 5; ++i) frames.push_back(camera->next_frame(1s, CameraDevice::Pixels::keep));
  const double white = mean(frames.back().dn);
  ASSERT_GT(white, black + 500.0);
  for (const Frame& frame : frames) {
    const double begin_ms = static_cast<double>(frame.timestamp_ns - shown) / kNsPerMs - 10.0;
    const double lit = std::clamp((begin_ms + 10.0 - 20.0) / 10.0, 0.0, 1.0);
    EXPECT_NEAR((mean(frame.dn) - black) / (white - black), lit, 1e-3) << begin_ms;  // rounding to DN
  }
}

TEST_F(SimulatedRigTest, GrayValuesFollowTheExposure) {
  const SimulatedRig devices = rig(plane_twin());
  const auto camera = devices.camera(0);
  const auto display = devices.display();
  camera->start();
  display->show(even_field(1.0, "white"), {});
  const double at_10 = mean(frame_after(*camera, 4).dn) - 20.0;
  EXPECT_EQ(camera->set_exposure_ms(5.0), 5.0);
  const double at_5 = mean(frame_after(*camera, 2).dn) - 20.0;
  EXPECT_NEAR(at_5 / at_10, 0.5, 1e-3);
  camera->set_exposure_ms(40.0);  // longer than a frame: the period stretches
  EXPECT_NEAR(*camera->info().period_ms, 40.0, 1e-12);
  EXPECT_THROW(camera->set_exposure_ms(1e6), UserError);
}

TEST_F(SimulatedRigTest, AResumedRunSeesTheSameNoise) {
  Twin twin = plane_twin();
  twin.cameras[0].sensor.read_noise_dn = 3.0;
  const auto second_pattern = [&](int frames_before) {
    const SimulatedRig devices = rig(twin);
    const auto camera = devices.camera(0);
    const auto display = devices.display();
    camera->start();
    if (frames_before > 0) {
      display->show(sequence_patterns(twin.fringes)[0], {});
      frame_after(*camera, frames_before);
    }
    camera->drain();
    display->show(sequence_patterns(twin.fringes)[1], {});
    return frame_after(*camera, 3).dn.data;
  };
  const auto alone = second_pattern(0);
  EXPECT_EQ(second_pattern(3), alone);
  EXPECT_NE(second_pattern(3), std::vector<std::uint16_t>(alone.size(), alone[0]));
}

TEST_F(SimulatedRigTest, FramesAreNumberedAndStamped) {
  const SimulatedRig devices = rig(plane_twin());
  const auto camera = devices.camera(0);
  camera->start();
  const Frame first = camera->next_frame(1s, CameraDevice::Pixels::drop);
  EXPECT_TRUE(first.dn.empty());
  const Frame second = camera->next_frame(1s, CameraDevice::Pixels::drop);
  EXPECT_EQ(second.sequence, first.sequence + 1);
  EXPECT_NEAR(static_cast<double>(second.timestamp_ns - first.timestamp_ns), 1e9 / 60.0, 1.0);
}

}  // namespace
}  // namespace fringetwin::testing::simulated_rig_test
