// SPDX-License-Identifier: Apache-2.0
// Runs an acquisition that the projector leads: it shows the whole sequence by itself and pulses the cameras,
// which are armed before; a run is kept when each pulse has its frame in each camera, else the next is taken.
#pragma once
#include <map>
#include <string>

#include "capture/record/session.hpp"

namespace fringetwin::capture {

struct PulseOptions {
  std::chrono::milliseconds wait{60'000};  ///< for the first pulse of a run
  std::chrono::milliseconds pause{500};    ///< without a frame, after which a run has ended
};

/// Throws UserError(usage) for what a projector that runs by itself cannot do: a plan has one frame of each
/// pattern, at one exposure, and nothing else.
void check_pulse_plan(const CapturePlan& plan, const std::string& line);

/// Records one whole run unless `recording` has one, and finishes it. All cameras have
/// CameraInfo::pulse_line.
/// Throws UserError(device) when no pulse comes, when none of CapturePlan::attempts runs is right, or when a
/// device fails for good; no image of a wrong run is written.
SessionSummary record_pulses(const Twin& twin, const Rig& rig, const CapturePlan& plan,
                             const PulseOptions& options, Recording& recording,
                             const std::map<std::string, std::string>& provenance);

}  // namespace fringetwin::capture
