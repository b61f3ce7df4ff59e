// SPDX-License-Identifier: Apache-2.0
// Latency, exposure and preview on the simulated rig, whose latency, irradiance and blur are known.
//
// | check    | tolerance          | origin |
// |----------|--------------------|--------------------------------------------------------------------------|
// | latency  | one frame, 16.7 ms | a simulated display shows where a frame ends: its phase is always the
// same | | exposure | 2 %                | to 1 % by design, the level to one of 255 | | contrast | 5e-3 | 12
// bit values of some 1500 DN                                            |
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "capture/adjust/exposure_choice.hpp"
#include "capture/adjust/latency.hpp"
#include "capture/adjust/preview.hpp"
#include "capture/rehearse/simulated_rig.hpp"
#include "tests/support/capture/loop_rig.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::testing::rig_help_test {
namespace {

using namespace fringetwin::capture;
using testing::loop_twin;

Twin plane_twin(int bits) {
  Twin twin = loop_twin(2, bits);
  twin.projector->intensity = 10.0;
  twin.projector->T_proj_world.translation_mm = {-20.0, 0.0, 0.0};
  twin.cameras[1].T_cam_world.translation_mm = {-10.0, 0.0, 0.0};
  for (Camera& camera : twin.cameras) {
    camera.sensor.exposure_ms = 8.0;
    camera.sensor.gain_dn = bits == 8 ? 30.0 : 480.0;
    camera.sensor.black_level_dn = 5.0;
    camera.sensor.read_noise_dn = bits == 8 ? 0.7 : 4.0;
  }
  Object object{"plane", PlaneShape{{0, 0, 400}, {0, 0, -1}, std::nullopt}, Material()};
  twin.objects.push_back(object);
  return twin;
}

class RigHelp : public ::testing::Test {
 protected:
  RigHelp() { set_quiet(true); }
  ~RigHelp() override { set_quiet(false); }
  void open(const Twin& twin, const SimulatedOptions& options = {}) {
    const SimulatedRig devices(twin, render::choose_sampling(twin), renderer_, options);
    cameras_.clear();
    for (std::size_t c = 0; c < twin.cameras.size(); ++c)
      cameras_.push_back({twin.cameras[c].name, twin.cameras[c].sensor.bit_depth, devices.camera(c)});
    display_ = devices.display();
  }
  render::Renderer renderer_;
  Rig cameras_;
  std::unique_ptr<PatternDisplay> display_;
};

TEST_F(RigHelp, TheLatencyIsFound) {
  for (const double latency_ms : {0.0, 7.0, 20.0, 61.0}) {
    SimulatedOptions options;
    options.latency_ms = latency_ms;
    open(plane_twin(12), options);
    const Latency latency = calibrate_latency(cameras_, *display_, {.changes = 12});
    EXPECT_GE(latency.latency_ms, latency_ms);
    EXPECT_LE(latency.latency_ms, latency_ms + 1000.0 / 60.0 + latency.margin_ms);
    EXPECT_EQ(latency.settle_frames, 0);
    EXPECT_LE(latency.settle_without_latency, std::ceil(latency_ms * 60.0 / 1000.0));
  }
}

TEST_F(RigHelp, TheExposureIsThatOfTheClosedForm) {
  for (const int bits : {8, 12}) {
    const Twin twin = plane_twin(bits);
    open(twin);
    const auto choices = choose_exposures(cameras_, *display_, {.latency_ms = 20.0});
    for (std::size_t c = 0; c < 2; ++c) {
      ImageF white = *renderer_.render(twin, c, render::choose_sampling(twin), 0, true).white;
      std::sort(white.data.begin(), white.data.end());
      const auto beyond = static_cast<std::size_t>(0.001 * static_cast<double>(white.size()));
      const double brightest = white.data[white.size() - 1 - beyond];
      const Sensor& sensor = twin.cameras[c].sensor;
      const double best_ms =
          8.0 * (sensor.max_dn() - 0.5 - sensor.black_level_dn) / (sensor.gain_dn * brightest);
      EXPECT_NEAR(choices[c].exposure_ms, best_ms, 0.02 * best_ms) << bits;
      EXPECT_LE(choices[c].saturated_share, 0.001);
    }
  }
}

TEST_F(RigHelp, ThePreviewSeesTheProjectorsBlur) {
  Twin twin = plane_twin(12);
  twin.fringes.amplitude = 0.4;
  CapturePlan plan;
  plan.latency_ms = 20.0;
  const double pitch_px = twin.fringes.directions[0].pitches_px[0];
  for (const double blur_px : {0.0, 1.0, 2.5}) {
    twin.projector->blur_px = blur_px;
    open(twin);
    Preview preview(twin, cameras_, *display_, plan);
    for (const PreviewNumbers& found : preview.look()) {
      const double kept = std::exp(-2.0 * std::pow(std::numbers::pi * blur_px / pitch_px, 2));
      // a camera's pixel is as wide as a projector's: it averages over 1/13 of a period
      const double pixel = std::sin(std::numbers::pi / pitch_px) / (std::numbers::pi / pitch_px);
      EXPECT_NEAR(found.contrast, 0.8 * kept * pixel, 5e-3) << blur_px;
      EXPECT_EQ(found.saturated_share, 0.0);
    }
  }
}

}  // namespace
}  // namespace fringetwin::testing::rig_help_test
