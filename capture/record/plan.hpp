// SPDX-License-Identifier: Apache-2.0
// Turns what a user wants recorded (CapturePlan) into the steps of a recording in their order: one for each
// showing of a pattern.
#pragma once
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/device/pattern.hpp"
#include "twin/twin.hpp"

namespace fringetwin::capture {

struct CapturePlan {
  int settle_frames = 2;             ///< left out after a pattern has come on
  double latency_ms = 0.0;           ///< from Shown::at_ns until the light has changed (--calibrate-latency)
  int average = 1;                   ///< frames per image
  int repeats = 1;                   ///< images per pattern, a set of its own each, for photon transfer
  std::vector<double> exposures_ms;  ///< empty: as the cameras stand; several: a set each, and one merged
  bool references = false;           ///< white and black images, also where the sequence needs none
  int dark_frames = 0;  ///< single frames while the projector shows black, before all others of an exposure
  int flat_frames = 0;  ///< the same with white, after all others
  std::optional<double> max_skew_ms;        ///< between the cameras' frames; default: one frame period
  std::chrono::milliseconds timeout{2000};  ///< for one frame, and for a lost signal to come back
  int attempts = 5;                         ///< at a step before the recording gives up
  bool brackets() const { return exposures_ms.size() > 1; }
};

/// An image file of each camera: SET/CAMERA/NAME.png.
struct Picture {
  std::string set;                                    ///< sub-folder, "" = the main set
  std::string name;                                   ///< "0003", "white"
  std::string file(const std::string& camera) const;  ///< relative, with '/'
};

/// One showing of a pattern: `average` frames for each of its pictures.
struct Step {
  Pattern pattern;
  std::optional<double> exposure_ms;
  int average = 1;
  bool in_sequence = true;  ///< false: dark and flat frames
  std::vector<Picture> pictures;
};

/// A capture set among what is recorded.
struct RecordedSet {
  std::string folder;  ///< "" = the main set
  std::optional<double> exposure_ms;
  bool references = false;
};

/// Throws UserError(usage) for numbers out of range or at odds (brackets with repeats).
void check_plan(const CapturePlan& plan);
std::vector<Step> make_steps(const Fringes& fringes, const CapturePlan& plan);
/// Returns the capture sets of a recording, without dark and flat frames, which are plain folders. With
/// brackets the main set is merged at the end.
std::vector<RecordedSet> recorded_sets(const Fringes& fringes, const CapturePlan& plan);

/// Returns by name all that must not change between a recording and its --resume; times and tries may.
std::map<std::string, std::string> plan_identity(const Twin& twin, const CapturePlan& plan);

}  // namespace fringetwin::capture
