// SPDX-License-Identifier: Apache-2.0
#include "capture/grab.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "twin/errors.hpp"
#include "twin/progress.hpp"

namespace fringetwin::capture {
namespace {

constexpr int kFewestFrames = 20;  ///< given to a camera before "no good frame" is said

std::string use_of(const Picture& picture) {
  return picture.set.empty() ? picture.name : picture.set + "/" + picture.name;
}

}  // namespace

TimeNs exposure_begin_ns(const Frame& frame, const CameraInfo& info, std::optional<double> exposure_ms) {
  if (info.timestamp_at_exposure_start) return frame.timestamp_ns;
  return frame.timestamp_ns - to_ns(exposure_ms.value_or(0.0));
}

FrameJudge::FrameJudge(const RigCamera& camera, const Step& step, TimeNs from_ns, int settle_frames)
    : camera_(camera),
      step_(step),
      info_(camera.device->info()),
      exposure_ms_(camera.device->exposure_ms()),
      from_ns_(from_ns),
      settle_left_(settle_frames),
      wanted_(step.average * static_cast<int>(step.pictures.size())),
      averages_(step.pictures.size(), FrameAverage(info_.bit_depth, camera.stored_bits)) {}

CameraDevice::Pixels FrameJudge::pixels() const {
  return settle_left_ > 0 ? CameraDevice::Pixels::drop : CameraDevice::Pixels::keep;
}

std::string FrameJudge::judge(const Frame& frame, StepRecord* record) {
  // Cameras count frames in 32 bits, which wrap: the difference tells the order.
  const std::int32_t advance =
      last_sequence_ ? static_cast<std::int32_t>(frame.sequence - *last_sequence_) : 1;
  if (advance <= 0 || (last_sequence_ && frame.timestamp_ns <= last_timestamp_ns_)) {
    ++record->repeated_frames;
    return "repeated";
  }
  record->lost_frames += static_cast<std::uint32_t>(advance - 1);
  last_sequence_ = frame.sequence;
  last_timestamp_ns_ = frame.timestamp_ns;
  if (exposure_begin_ns(frame, info_, exposure_ms_) < from_ns_) return "stale";
  if (settle_left_ > 0) {
    --settle_left_;
    return "settling";
  }
  if (frame.fault != FrameFault::none) {
    ++record->corrupt_frames;
    return frame_fault_name(frame.fault);
  }
  return "";
}

void FrameJudge::take(const Frame& frame, StepRecord* record) {
  std::string use = judge(frame, record);
  if (use.empty()) {
    const std::size_t picture = static_cast<std::size_t>(good_ / step_.average);
    averages_[picture].add(frame.dn, info_.device);
    begins_ns_.push_back(exposure_begin_ns(frame, info_, exposure_ms_));
    use = use_of(step_.pictures[picture]);
    ++good_;
  }
  record->frames.push_back({camera_.name, frame.sequence, frame.timestamp_ns, frame.flags, std::move(use)});
}

std::vector<ImageF> FrameJudge::images() const {
  std::vector<ImageF> images;
  for (const FrameAverage& average : averages_) images.push_back(average.stored());
  return images;
}

Grabbed grab(const Rig& rig, const Step& step, const CapturePlan& plan, StepRecord* record) {
  const TimeNs from_ns = record->shown.at_ns + to_ns(plan.latency_ms);
  std::vector<FrameJudge> judges;
  for (const RigCamera& camera : rig) judges.emplace_back(camera, step, from_ns, plan.settle_frames);
  const int wanted = step.average * static_cast<int>(step.pictures.size());
  const int most = plan.settle_frames + kFewestFrames + plan.attempts * wanted;
  for (int taken = 0;; ++taken) {
    throw_if_cancelled();
    bool all_done = true;
    // In turn, so that no camera's buffers run full while another is waited for.
    for (std::size_t c = 0; c < rig.size(); ++c) {
      if (judges[c].done()) continue;
      all_done = false;
      if (taken == most)
        throw DeviceFault(DeviceFault::Kind::timeout,
                          fmt::format("camera \"{}\": fewer than {} good frames among {}; the last one: {}",
                                      rig[c].name, wanted, most, record->frames.back().use));
      judges[c].take(rig[c].device->next_frame(plan.timeout, judges[c].pixels()), record);
    }
    if (all_done) break;
  }
  Grabbed grabbed;
  for (std::size_t c = 0; c < rig.size(); ++c) {
    grabbed.images.push_back(judges[c].images());
    for (std::size_t i = 0; c > 0 && i < judges[c].begins_ns().size(); ++i) {
      const TimeNs apart = judges[c].begins_ns()[i] - judges[0].begins_ns()[i];
      record->skew_ms = std::max(record->skew_ms, std::abs(static_cast<double>(apart)) / kNsPerMs);
    }
  }
  return grabbed;
}

}  // namespace fringetwin::capture
