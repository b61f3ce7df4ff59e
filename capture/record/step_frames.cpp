// SPDX-License-Identifier: Apache-2.0
#include "capture/record/step_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::capture {
namespace {

constexpr const char* kTooEarly = "before its pair";
constexpr int kFewestFrames = 20;  ///< given to a camera before "no good frame" is said

std::string use_of(const Picture& picture) {
  return picture.set.empty() ? picture.name : picture.set + "/" + picture.name;
}

}  // namespace

FrameJudge::FrameJudge(const RigCamera& camera, const Step& step, TimeNs from_ns, int settle_frames,
                       bool leads)
    : camera_(camera),
      step_(step),
      info_(camera.device->info()),
      exposure_ms_(camera.device->exposure_ms()),
      from_ns_(from_ns),
      settle_left_(settle_frames),
      wanted_(step.average * static_cast<int>(step.pictures.size())),
      averages_(step.pictures.size(), FrameAverage(info_.bit_depth, camera.stored_bits)) {
  if (leads) first_begin_ns_ = std::numeric_limits<TimeNs>::min();
}

CameraDevice::Pixels FrameJudge::pixels() const {
  return settle_left_ > 0 ? CameraDevice::Pixels::drop : CameraDevice::Pixels::keep;
}

std::string FrameJudge::judge(const Frame& frame, StepRecord* record) {
  const std::uint32_t ahead = order_.advance(frame);
  if (ahead == 0) {
    ++record->repeated_frames;
    return "repeated";
  }
  record->lost_frames += ahead - 1;
  if (frame.fault != FrameFault::none) {
    ++record->corrupt_frames;
    return frame_fault_name(frame.fault);
  }
  if (exposure_begin_ns(frame, info_, exposure_ms_) < from_ns_) return "stale";
  if (settle_left_ > 0) {
    --settle_left_;
    return "settling";
  }
  return "";
}

void FrameJudge::use(Frame frame, FrameRecord* record) {
  const std::size_t picture = static_cast<std::size_t>(good_ / step_.average);
  begins_ns_.push_back(exposure_begin_ns(frame, info_, exposure_ms_));
  averages_[picture].add(std::move(frame.dn), info_.device);
  record->use = use_of(step_.pictures[picture]);
  record->good = true;
  ++good_;
}

void FrameJudge::take(Frame frame, StepRecord* record) {
  record->frames.push_back(
      {camera_.name, frame.sequence, frame.timestamp_ns, frame.flags, "", record->shown});
  FrameRecord& entry = record->frames.back();
  entry.use = judge(frame, record);
  if (!entry.use.empty()) return;
  if (first_begin_ns_) {
    if (exposure_begin_ns(frame, info_, exposure_ms_) >= *first_begin_ns_)
      use(std::move(frame), &entry);
    else
      entry.use = kTooEarly;
    return;
  }
  entry.use = kTooEarly;  // unless pair_with() says otherwise
  candidate_ = Candidate{std::move(frame), record->frames.size() - 1};
}

void FrameJudge::pair_with(TimeNs leader_begin_ns, StepRecord* record) {
  first_begin_ns_ =
      info_.period_ms ? leader_begin_ns - to_ns(*info_.period_ms / 2.0) : std::numeric_limits<TimeNs>::min();
  if (!candidate_) return;
  if (exposure_begin_ns(candidate_->frame, info_, exposure_ms_) >= *first_begin_ns_)
    use(std::move(candidate_->frame), &record->frames[candidate_->record]);
  candidate_.reset();
}

std::vector<ImageF> FrameJudge::images() const {
  std::vector<ImageF> images;
  for (const FrameAverage& average : averages_) images.push_back(average.stored());
  return images;
}

namespace {

/// The unfinished camera whose frames are furthest behind: nobody's buffers run full meanwhile, and frames
/// come in order of time.
std::size_t next_camera(const std::vector<FrameJudge>& judges) {
  std::size_t next = judges.size();
  for (std::size_t c = 0; c < judges.size(); ++c)
    if (!judges[c].done() &&
        (next == judges.size() || judges[c].last_timestamp_ns() < judges[next].last_timestamp_ns()))
      next = c;
  return next;
}

/// From the first frame of each image to the nearest frame that the first camera used: frames lost by one
/// camera do not put all later ones apart.
double worst_skew_ms(const std::vector<FrameJudge>& judges, std::size_t average) {
  TimeNs worst = 0;
  const std::vector<TimeNs>& leader = judges[0].begins_ns();
  for (std::size_t c = 1; c < judges.size(); ++c)
    for (std::size_t i = 0; i < judges[c].begins_ns().size(); i += average) {
      const TimeNs begin = judges[c].begins_ns()[i];
      TimeNs nearest = std::numeric_limits<TimeNs>::max();
      for (const TimeNs other : leader) nearest = std::min(nearest, std::abs(begin - other));
      worst = std::max(worst, nearest);
    }
  return static_cast<double>(worst) / kNsPerMs;
}

/// Triggered cameras begin together, once the light has changed.
void trigger_all(const Rig& rig, TimeNs from_ns) {
  if (std::ranges::none_of(rig, [](const RigCamera& camera) { return camera.device->info().triggered; }))
    return;
  const TimeNs wait_ns = from_ns - rig.front().device->now_ns();
  if (wait_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(wait_ns));
  for (const RigCamera& camera : rig) camera.device->trigger();
}

}  // namespace

StepImages take_step_frames(const Rig& rig, const Step& step, const CapturePlan& plan, StepRecord* record) {
  const TimeNs from_ns = record->shown.at_ns + to_ns(plan.latency_ms);
  std::vector<FrameJudge> judges;
  for (std::size_t c = 0; c < rig.size(); ++c)
    judges.emplace_back(rig[c], step, from_ns, plan.settle_frames, c == 0);
  const int wanted = step.average * static_cast<int>(step.pictures.size());
  const int most = plan.settle_frames + kFewestFrames + plan.attempts * wanted;
  std::vector<int> taken(rig.size(), 0);
  bool paired = false;
  trigger_all(rig, from_ns);
  for (std::size_t c; (c = next_camera(judges)) < rig.size();) {
    throw_if_cancelled();
    if (taken[c]++ == most)
      throw DeviceFault(DeviceFault::Kind::timeout,
                        fmt::format("camera \"{}\": fewer than {} good frames among {}; the last one: {}",
                                    rig[c].name, wanted, most, record->frames.back().use));
    judges[c].take(rig[c].device->next_frame(plan.timeout, judges[c].pixels()), record);
    if (paired || judges[0].begins_ns().empty()) continue;
    for (std::size_t other = 1; other < rig.size(); ++other)
      judges[other].pair_with(judges[0].begins_ns().front(), record);
    paired = true;
  }
  StepImages grabbed;
  for (const FrameJudge& judge : judges) grabbed.images.push_back(judge.images());
  record->skew_ms = worst_skew_ms(judges, static_cast<std::size_t>(step.average));
  return grabbed;
}

}  // namespace fringetwin::capture
