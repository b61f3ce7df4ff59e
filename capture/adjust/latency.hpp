// SPDX-License-Identifier: Apache-2.0
// Measures, from the images themselves, how long it takes from the call that shows a pattern to the frames
// that show nothing else.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"
#include "capture/device/pattern_display.hpp"

namespace fringetwin::capture {

struct LatencyOptions {
  int changes = 40;
  double patience_ms = 1000.0;  ///< no display is later than this; the levels are learnt after so long
  std::uint64_t seed = 1;       ///< of the run lengths
  std::chrono::milliseconds timeout{2000};
};

struct Spread {
  double min = 0.0, median = 0.0, max = 0.0;
};

/// Times are those at which exposures begin, after Shown::at_ns, as the recording reckons them
/// (exposure_begin_ns). Frames are counted from 1: the first whose exposure begins after Shown::at_ns.
struct CameraLatency {
  std::string camera;
  double black_dn = 0.0, white_dn = 0.0;
  double threshold = 0.0;         ///< share of the change that counts as seen
  Spread begins_ms, complete_ms;  ///< the first frame with some of the new light; the first with nothing else
  Spread begins_frames, complete_frames;
  int changes = 0, discarded = 0;  ///< used; left out for lost or faulty frames
  int most_mixed = 0;              ///< frames in a row that show neither level
  bool steady = false;             ///< one latency explains all changes
  double needed_ms = 0.0;          ///< frames that begin so much later showed the new light only
};

struct Latency {
  std::vector<CameraLatency> cameras;
  /// What CapturePlan is given: the needed_ms of the slowest camera and a margin of 0.5 ms + threshold x
  /// frame period (the share of old light that would go unseen in a frame).
  double latency_ms = 0.0, margin_ms = 0.0;
  int settle_frames = 0;  ///< besides; 1 where latency scatters or the display does not say when it shows
  int settle_without_latency = 0;          ///< that do without latency_ms
  std::vector<std::string> lines() const;  ///< for the terminal
};

/// Alternates black and white in runs of random length, so that no whole number of frames can hide. Throws
/// UserError(device) as LightLevels does, and when changes are not seen whole; DeviceFault.
Latency calibrate_latency(const Rig& rig, PatternDisplay& display, const LatencyOptions& options = {});

}  // namespace fringetwin::capture
