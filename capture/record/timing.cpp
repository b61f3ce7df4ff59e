// SPDX-License-Identifier: Apache-2.0
#include "capture/record/timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace fringetwin::capture {
namespace {

constexpr double kFlickerShown = 2e-3;  ///< 59.94 Hz for 60 is 0.1 %; noise of a pixel is above 0.5 %

int frames_of(const Step& step) { return step.average * static_cast<int>(step.pictures.size()); }

/// Returns the number of whole frames next to an exposure; 1 at least.
double whole_frames(double exposure_ms, double frame_ms) {
  return std::max(1.0, std::round(exposure_ms / frame_ms));
}

/// Time of one camera for the frames of a step; nullopt where the device does not say.
std::optional<double> camera_ms(const CameraTiming& camera, const Step& step, const CapturePlan& plan) {
  const std::optional<double> exposure_ms = step.exposure_ms ? step.exposure_ms : camera.exposure_ms;
  const int n = frames_of(step);
  if (camera.triggered)
    return exposure_ms ? std::optional(*exposure_ms * (n + plan.settle_frames)) : std::nullopt;
  if (!camera.period_ms && !exposure_ms) return std::nullopt;
  const double period_ms = std::max(camera.period_ms.value_or(0.0), exposure_ms.value_or(0.0));
  return period_ms * (0.5 + n + plan.settle_frames);  // a frame that has begun is let pass
}

}  // namespace

RigTiming rig_timing(const Rig& rig, const DisplayInfo& display, std::optional<double> projector_frame_ms) {
  RigTiming timing{projector_frame_ms ? projector_frame_ms : display.frame_ms, {}};
  for (const RigCamera& camera : rig) {
    const CameraInfo info = camera.device->info();
    timing.cameras.push_back({camera.name, camera.device->exposure_ms(), info.period_ms, info.triggered});
  }
  return timing;
}

std::optional<double> least_seconds(const RigTiming& timing, const std::vector<Step>& steps,
                                    const CapturePlan& plan) {
  double sum_ms = 0.0;
  for (const Step& step : steps) {
    double longest_ms = 0.0;
    for (const CameraTiming& camera : timing.cameras) {
      const std::optional<double> one_ms = camera_ms(camera, step, plan);
      if (!one_ms) return std::nullopt;
      longest_ms = std::max(longest_ms, *one_ms);
    }
    sum_ms += plan.latency_ms + longest_ms;
  }
  return 1e-3 * sum_ms;
}

double flicker_share(double exposure_ms, double projector_frame_ms) {
  const double frames = exposure_ms / projector_frame_ms;
  return std::abs(frames - whole_frames(exposure_ms, projector_frame_ms)) / frames;
}

std::vector<std::string> flicker_warnings(const RigTiming& timing, const std::vector<double>& exposures_ms) {
  std::vector<std::string> warnings;
  if (!timing.projector_frame_ms) return warnings;
  const double frame_ms = *timing.projector_frame_ms;
  for (const CameraTiming& camera : timing.cameras) {
    std::vector<double> all = exposures_ms;
    if (all.empty() && camera.exposure_ms) all.push_back(*camera.exposure_ms);
    for (const double exposure_ms : all) {
      const double share = flicker_share(exposure_ms, frame_ms);
      if (share <= kFlickerShown) continue;
      const double whole_ms = frame_ms * whole_frames(exposure_ms, frame_ms);
      warnings.push_back(
          fmt::format("camera \"{}\": an exposure of {:.6g} ms is {:.4g} frames of the projector ({:.6g} "
                      "ms); light that it "
                      "makes in the course of a frame differs by up to {:.2g} % from image to image: expose "
                      "for {:.6g} ms",
                      camera.name, exposure_ms, exposure_ms / frame_ms, frame_ms,
                      100.0 * std::min(share, 1.0), whole_ms));
    }
  }
  return warnings;
}

std::string plan_text(const RigTiming& timing, const std::vector<Step>& steps, const CapturePlan& plan) {
  int frames = 0;
  for (const Step& step : steps) frames += frames_of(step);
  const std::optional<double> seconds = least_seconds(timing, steps, plan);
  return fmt::format("{} patterns, {} frames of each camera{}", steps.size(), frames,
                     seconds ? fmt::format(": {:.1f} s at least", *seconds) : "");
}

}  // namespace fringetwin::capture
