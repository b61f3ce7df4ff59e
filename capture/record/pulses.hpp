// SPDX-License-Identifier: Apache-2.0
// Judges the frames that cameras took of one run of a projector that pulses them: whether each pulse of the
// sequence has one whole frame in each camera, and which pulse is missing, doubled or damaged if not.
// Knows no devices.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"

namespace fringetwin::capture {

/// A frame, as far as it tells of its pulse.
struct PulseFrame {
  TimeNs camera_ns = 0;        ///< on one clock for all frames of a camera, another for each camera
  std::uint64_t block_id = 0;  ///< the camera's count, without wraps
  std::string damage = {};     ///< "": whole; "missing packets"...: its time is not looked at
};

/// The frames of one camera in the order in which they came.
struct PulseTrain {
  std::string camera;
  std::vector<PulseFrame> frames;
  bool has_shared_clock = false;  ///< set by the network (PTP): that of all cameras which say so
};

struct PulseFault {
  enum class Kind {
    missing,    ///< the camera took no frame for a pulse, or the projector sent none
    doubled,    ///< two frames for one pulse
    lost,       ///< the camera counted a frame that never came
    damaged,    ///< the frame came with holes
    irregular,  ///< a pulse came between the times of two others
    too_few,    ///< fewer than expected, and which are missing is not known
    too_many,
    apart,  ///< the pulses of two cameras are not the same
  };
  Kind kind = Kind::missing;
  std::string camera;
  int pulse = 0;         ///< from 1; 0: not known
  std::string sentence;  ///< `pulse 7 of 24 is missing in camera "left"`
};

struct PulseVerdict {
  std::vector<PulseFault> faults;
  double interval_ms = 0.0;  ///< from pulse to pulse; 0: not known
  std::vector<double>
      skew_ms;  ///< of each pulse: the largest distance in time from its frame in the first
                ///< camera, but for offset and drift of clocks that are not shared; empty for one camera
  /// By camera, then by frame: what is wrong with it; "" for nothing.
  std::vector<std::vector<std::string>> frame_faults;

  bool right() const { return faults.empty(); }
  int count(PulseFault::Kind kind) const;
  /// Returns the first faults in one sentence, with the number of the others.
  std::string sentence() const;
};

/// The pulses of a run come at one interval; a quarter of it off is another pulse. A camera's clock may be
/// off by any offset, and by a thousandth in rate, unless it is shared.
PulseVerdict judge_pulses(const std::vector<PulseTrain>& trains, int expected);

}  // namespace fringetwin::capture
