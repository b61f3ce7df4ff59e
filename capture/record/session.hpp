// SPDX-License-Identifier: Apache-2.0
// Runs a whole acquisition: every pattern of the plan is shown, settled, recorded by all cameras, checked,
// and kept.
#pragma once
#include <map>
#include <string>

#include "capture/device/pattern_display.hpp"
#include "capture/record/plan.hpp"
#include "capture/record/recording.hpp"
#include "capture/record/step_frames.hpp"
#include "twin/twin.hpp"

namespace fringetwin::capture {

/// Counts of what happened on the way, for the user and for provenance.
struct SessionSummary {
  int steps = 0, recorded = 0;  ///< of the plan; in this run
  std::uint32_t lost_frames = 0;
  int repeated_frames = 0, corrupt_frames = 0, retries = 0;
  double worst_skew_ms = 0.0;
  double seconds = 0.0;
};

/// Throws UserError(device|usage) when a camera or the display does not fit the twin: sizes, bit depths.
void check_rig(const Twin& twin, const Rig& rig, const PatternDisplay& display, const CapturePlan& plan);

/// The same of the cameras alone, for a projector that is no display of ours.
void check_cameras(const Twin& twin, const Rig& rig, const CapturePlan& plan);

/// Sets and file names carry the exposure: throws UserError(device) when a control's step would change it
/// unsaid.
void set_exposure_exactly(CameraDevice& device, double exposure_ms);

/// plan_identity() and the exposures that the cameras have, where the plan names none: frames of another
/// exposure do not belong into the set.
std::map<std::string, std::string> recording_identity(const Twin& twin, const Rig& rig,
                                                      const CapturePlan& plan);
/// Gives the cameras the exposures that an unfinished recording was begun with; false when it names none.
bool restore_exposures(const std::map<std::string, std::string>& identity, const Rig& rig);

/// Returns `provenance` with what the devices report and with the counts of a recording, for capture.toml.
std::map<std::string, std::string> recording_provenance(const Rig& rig, const DisplayInfo& projector,
                                                        const CapturePlan& plan, const Recording& recording,
                                                        std::map<std::string, std::string> provenance);

/// Records the steps that `recording` does not have yet and finishes it. `provenance` goes into capture.toml
/// beside what the devices report.
/// Throws UserError(device) when a device fails for good; what was recorded stays, for --resume.
SessionSummary record_session(const Twin& twin, const Rig& rig, PatternDisplay& display,
                              const CapturePlan& plan, Recording& recording,
                              const std::map<std::string, std::string>& provenance);

}  // namespace fringetwin::capture
