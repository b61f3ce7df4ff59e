// SPDX-License-Identifier: Apache-2.0
// Takes the frames of one step of a plan (one showing of a pattern) from all cameras, judges each frame, and
// returns the averages of the good ones.
#pragma once
#include <limits>
#include <optional>
#include <vector>

#include "capture/device/camera_device.hpp"
#include "capture/device/frame_average.hpp"
#include "capture/record/journal.hpp"
#include "capture/record/plan.hpp"
#include "twin/twin.hpp"

namespace fringetwin::capture {

/// Judges one camera's frames in order and sums the good ones. Cameras that run freely are paired with the
/// first camera: the others begin with the frame nearest in time to its first good one.
class FrameJudge {
 public:
  /// `wanted`: good frames in all. `from_ns`: the light has changed (Shown::at_ns and latency).
  /// `leads`: the first camera, which needs no pair_with().
  FrameJudge(const RigCamera& camera, const Step& step, TimeNs from_ns, int settle_frames, bool leads);

  bool done() const { return good_ == wanted_; }
  TimeNs last_timestamp_ns() const { return order_.last_ns(); }
  CameraDevice::Pixels pixels() const;  ///< what the next frame is asked for
  /// Adds the record of the frame to `record`.
  void take(Frame frame, StepRecord* record);
  /// The first camera's first good frame began then.
  void pair_with(TimeNs leader_begin_ns, StepRecord* record);

  std::vector<ImageF> images() const;                                  ///< one per picture
  const std::vector<TimeNs>& begins_ns() const { return begins_ns_; }  ///< of the good frames

 private:
  std::string judge(const Frame& frame, StepRecord* record);
  void use(Frame frame, FrameRecord* record);

  /// Good, but perhaps earlier than the frame to be paired with.
  struct Candidate {
    Frame frame;
    std::size_t record = 0;  ///< index into StepRecord::frames
  };

  const RigCamera& camera_;
  const Step& step_;
  CameraInfo info_;
  std::optional<double> exposure_ms_;
  TimeNs from_ns_;
  int settle_left_, wanted_, good_ = 0;
  std::optional<TimeNs> first_begin_ns_;  ///< frames that begin earlier are too early for the pair
  std::optional<Candidate> candidate_;
  FrameOrder order_;
  std::vector<FrameAverage> averages_;
  std::vector<TimeNs> begins_ns_;
};

/// What was seen of a step: images by camera, then by picture.
struct StepImages {
  std::vector<std::vector<ImageF>> images;
};

/// Takes frames of all cameras in turn until each has what the step wants. `record` gains frames and counts.
/// Throws DeviceFault; timeout, too, when a camera delivers no good frame among `plan.attempts` times as many
/// as are wanted.
StepImages take_step_frames(const Rig& rig, const Step& step, const CapturePlan& plan, StepRecord* record);

}  // namespace fringetwin::capture
