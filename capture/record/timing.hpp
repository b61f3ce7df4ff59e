// SPDX-License-Identifier: Apache-2.0
// What a recording will take, and whether the cameras' exposures hold whole frames of the projector: one that
// makes its light in the course of a frame (colour wheel, pulsed levels) gives other exposures more light now
// and less then.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "capture/device/pattern_display.hpp"
#include "capture/record/plan.hpp"

namespace fringetwin::capture {

struct CameraTiming {
  std::string name;
  std::optional<double> exposure_ms, period_ms;  ///< where the device says; of free-running frames
  bool triggered = false;
};

struct RigTiming {
  std::optional<double> projector_frame_ms;
  std::vector<CameraTiming> cameras;
};

/// `projector_frame_ms`: as the user knows it, else as the display says.
RigTiming rig_timing(const Rig& rig, const DisplayInfo& display, std::optional<double> projector_frame_ms);

/// Returns the least time of a recording: exposures, periods of frames that come by themselves, settling and
/// latency; what reading out, sending and writing take beside is not known. nullopt where a device says
/// neither exposure nor period.
std::optional<double> least_seconds(const RigTiming& timing, const std::vector<Step>& steps,
                                    const CapturePlan& plan);

/// Returns the share of an exposure's light that may differ from one exposure to the next where its light
/// comes evenly over a frame's time or in pieces: the time that is no whole number of frames, over the
/// exposure.
double flicker_share(double exposure_ms, double projector_frame_ms);

/// Returns a sentence for each camera and exposure whose light may differ by more than a gray value shows
/// (0.2 %); nothing where the projector's frame time is not known.
std::vector<std::string> flicker_warnings(const RigTiming& timing, const std::vector<double>& exposures_ms);

/// Returns "12 patterns, 96 frames of each camera: 8.2 s at least".
std::string plan_text(const RigTiming& timing, const std::vector<Step>& steps, const CapturePlan& plan);

}  // namespace fringetwin::capture
