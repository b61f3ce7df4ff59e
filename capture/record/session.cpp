// SPDX-License-Identifier: Apache-2.0
#include "capture/record/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "capture/record/streams.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::capture {
namespace {

using Clock = std::chrono::steady_clock;

/// Frames that a camera may still have taken with the exposure before, besides the settling ones.
constexpr int kFramesAfterExposureChange = 4;
constexpr double kExposureTolerance = 1e-3;  ///< relative: below any noise that an image shows

std::string exposure_key(const RigCamera& camera) { return "exposure_ms " + camera.name; }

/// Frame period of the slowest camera; nullopt where one does not say.
std::optional<double> slowest_period_ms(const Rig& rig) {
  double slowest = 0.0;
  for (const RigCamera& camera : rig) {
    const auto period = camera.device->info().period_ms;
    if (!period) return std::nullopt;
    slowest = std::max(slowest, *period);
  }
  return slowest;
}

class Session {
 public:
  Session(const Twin& twin, const Rig& rig, PatternDisplay& display, const CapturePlan& plan,
          Recording& recording)
      : twin_(twin), rig_(rig), display_(display), plan_(plan), recording_(recording), streams_(rig) {}

  SessionSummary run() {
    const auto begin = Clock::now();
    const std::vector<Step> steps = make_steps(twin_.fringes, plan_);
    summary_.steps = static_cast<int>(steps.size());
    Progress progress("capture", steps.size());
    for (int i = 0; i < summary_.steps; ++i) {
      if (!recording_.has(i)) {
        record_step(i, steps[i]);
        ++summary_.recorded;
      }
      progress.advance();
    }
    recording_.flush();
    summary_.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return summary_;
  }

 private:
  void record_step(int number, const Step& step) {
    StepRecord record;
    record.step = number;
    record.pattern = step.pattern.label;
    for (record.attempts = 1;; ++record.attempts) {
      const std::size_t earlier = record.frames.size();
      try {
        set_exposure(step);
        keep(step, show_and_grab(step, &record), record);
        return;
      } catch (const DeviceFault& fault) {
        give_up_frames(record, earlier);
        ++summary_.retries;
        recover(fault, step, record.attempts);
      }
    }
  }

  /// Whatever images the frames of this attempt would have gone into are taken anew.
  static void give_up_frames(StepRecord& record, std::size_t first) {
    for (std::size_t i = first; i < record.frames.size(); ++i)
      if (record.frames[i].good) record.frames[i].use = "given up";
  }

  void set_exposure(const Step& step) {
    if (!step.exposure_ms || step.exposure_ms == exposure_ms_) return;
    for (const RigCamera& camera : rig_) set_exposure_exactly(*camera.device, *step.exposure_ms);
    for (const RigCamera& camera : rig_) {
      camera.device->drain();
      for (int i = 0; i < kFramesAfterExposureChange; ++i)
        camera.device->next_frame(plan_.timeout, CameraDevice::Pixels::drop);
    }
    exposure_ms_ = step.exposure_ms;
  }

  StepImages show_and_grab(const Step& step, StepRecord* record) {
    display_.check();
    for (const RigCamera& camera : rig_) camera.device->check_input();
    record->shown = show_pattern(display_, twin_.fringes, step.pattern);
    record->skew_ms = 0.0;
    for (const RigCamera& camera : rig_) camera.device->drain();
    StepImages grabbed = take_step_frames(rig_, step, plan_, record);
    // A signal lost meanwhile leaves frames without an error flag.
    for (const RigCamera& camera : rig_) camera.device->check_input();
    check_skew(*record);
    return grabbed;
  }

  void check_skew(const StepRecord& record) {
    const std::optional<double> limit = plan_.max_skew_ms ? plan_.max_skew_ms : slowest_period_ms(rig_);
    if (limit && record.skew_ms > *limit)
      throw DeviceFault(
          DeviceFault::Kind::timeout,
          fmt::format("the cameras' frames are {:.2f} ms apart, more than the {:.2f} ms allowed",
                      record.skew_ms, *limit));
  }

  void keep(const Step& step, StepImages grabbed, const StepRecord& record) {
    std::vector<RecordedImage> images;
    for (std::size_t c = 0; c < rig_.size(); ++c)
      for (std::size_t p = 0; p < step.pictures.size(); ++p)
        images.push_back(
            {step.pictures[p].file(rig_[c].name), rig_[c].stored_bits, std::move(grabbed.images[c][p])});
    recording_.store(record, std::move(images));
    summary_.lost_frames += record.lost_frames;
    summary_.repeated_frames += record.repeated_frames;
    summary_.corrupt_frames += record.corrupt_frames;
    summary_.worst_skew_ms = std::max(summary_.worst_skew_ms, record.skew_ms);
  }

  void recover(const DeviceFault& fault, const Step& step, int attempts) {
    if (fault.kind() == DeviceFault::Kind::gone || attempts >= plan_.attempts) give_up(fault, step);
    warn(fmt::format("\"{}\": {}; tried again", step.pattern.label, fault.what()));
    if (fault.kind() == DeviceFault::Kind::no_signal) {
      if (!signal_comes_back()) give_up(fault, step);
    } else {
      try {
        streams_.restart_for_next_try();
      } catch (const DeviceFault& gone) {
        give_up(gone, step);
      }
    }
  }

  bool signal_comes_back() const {
    const auto end = Clock::now() + plan_.timeout;
    while (Clock::now() < end) {
      throw_if_cancelled();
      try {
        for (const RigCamera& camera : rig_) camera.device->check_input();
        return true;
      } catch (const DeviceFault&) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
    }
    return false;
  }

  [[noreturn]] void give_up(const DeviceFault& fault, const Step& step) {
    recording_.flush();
    throw UserError(
        ExitCode::device, fmt::format("pattern \"{}\"", step.pattern.label), fault.what(),
        fmt::format("{} of {} patterns are kept, go on with --resume", recording_.n_done(), summary_.steps));
  }

  const Twin& twin_;
  const Rig& rig_;
  PatternDisplay& display_;
  const CapturePlan& plan_;
  Recording& recording_;
  Streams streams_;
  SessionSummary summary_;
  std::optional<double> exposure_ms_;
};

}  // namespace

void set_exposure_exactly(CameraDevice& device, double exposure_ms) {
  const double got_ms = device.set_exposure_ms(exposure_ms);
  if (std::abs(got_ms - exposure_ms) > kExposureTolerance * exposure_ms)
    throw UserError(ExitCode::device, device.info().device,
                    fmt::format("cannot be exposed for {} ms, the nearest is {} ms", exposure_ms, got_ms),
                    fmt::format("ask for --exposure-ms {}", got_ms));
}

std::map<std::string, std::string> recording_provenance(const Rig& rig, const DisplayInfo& projector,
                                                        const CapturePlan& plan, const Recording& recording,
                                                        std::map<std::string, std::string> provenance) {
  for (const RigCamera& camera : rig) {
    const CameraInfo info = camera.device->info();
    provenance["device " + camera.name] = info.device;
    for (const auto& [key, value] : info.provenance) provenance[key + " " + camera.name] = value;
    if (const auto exposure_ms = camera.device->exposure_ms(); exposure_ms && !plan.brackets())
      provenance["exposure_ms " + camera.name] = fmt::format("{}", *exposure_ms);
  }
  provenance["device projector"] = projector.device;
  provenance["projector timing"] = projector.timed ? "page flips" : "not guaranteed";
  for (const auto& [key, value] : projector.provenance) provenance[key + " projector"] = value;
  std::uint32_t lost = 0;
  int repeated = 0, corrupt = 0;
  double skew_ms = 0.0;
  for (const StepRecord& record : recording.records()) {
    lost += record.lost_frames;
    repeated += record.repeated_frames;
    corrupt += record.corrupt_frames;
    skew_ms = std::max(skew_ms, record.skew_ms);
  }
  provenance["frames averaged"] = std::to_string(plan.average);
  provenance["settle frames"] = std::to_string(plan.settle_frames);
  provenance["latency_ms"] = fmt::format("{}", plan.latency_ms);
  provenance["frames lost"] = std::to_string(lost);
  provenance["frames repeated"] = std::to_string(repeated);
  provenance["frames corrupt"] = std::to_string(corrupt);
  if (rig.size() > 1) provenance["skew_ms"] = fmt::format("{:.3f}", skew_ms);
  return provenance;
}

void check_cameras(const Twin& twin, const Rig& rig, const CapturePlan& plan) {
  FT_CHECK(rig.size() == twin.cameras.size(), "a device for each camera of the twin");
  for (std::size_t c = 0; c < rig.size(); ++c) {
    const CameraInfo info = rig[c].device->info();
    const Lens& lens = twin.cameras[c].lens;
    if (info.width != lens.width() || info.height != lens.height())
      throw UserError(ExitCode::device, info.device,
                      fmt::format("delivers {} x {} px, camera \"{}\" of the twin has {} x {}", info.width,
                                  info.height, rig[c].name, lens.width(), lens.height()),
                      "check imagersize");
    check_depths(rig[c].name, info.bit_depth, rig[c].stored_bits, plan.average > 1 || plan.brackets());
  }
}

void check_rig(const Twin& twin, const Rig& rig, const PatternDisplay& display, const CapturePlan& plan) {
  check_cameras(twin, rig, plan);
  const DisplayInfo screen = display.info();
  const Lens& projector = twin.projector->lens;
  if (screen.width != projector.width() || screen.height != projector.height())
    throw UserError(ExitCode::device, screen.device,
                    fmt::format("shows {} x {} px, the twin's projector has {} x {}", screen.width,
                                screen.height, projector.width(), projector.height()),
                    "patterns are never scaled: choose a mode of that size, or check imagersize");
}

std::map<std::string, std::string> recording_identity(const Twin& twin, const Rig& rig,
                                                      const CapturePlan& plan) {
  std::map<std::string, std::string> identity = plan_identity(twin, plan);
  for (const RigCamera& camera : rig)
    if (const auto exposure_ms = camera.device->exposure_ms(); exposure_ms && plan.exposures_ms.empty())
      identity[exposure_key(camera)] = fmt::format("{}", *exposure_ms);
  return identity;
}

bool restore_exposures(const std::map<std::string, std::string>& identity, const Rig& rig) {
  bool any = false;
  for (const RigCamera& camera : rig) {
    const auto it = identity.find(exposure_key(camera));
    if (it == identity.end()) continue;
    const std::optional<double> exposure_ms = parse_number<double>(it->second);
    if (!exposure_ms)
      throw UserError(ExitCode::input, it->first, "\"" + it->second + "\" is no exposure in ms",
                      "record the set anew, or give the journal the number it had");
    camera.device->set_exposure_ms(*exposure_ms);
    any = true;
  }
  return any;
}

SessionSummary record_session(const Twin& twin, const Rig& rig, PatternDisplay& display,
                              const CapturePlan& plan, Recording& recording,
                              const std::map<std::string, std::string>& provenance) {
  SessionSummary summary = Session(twin, rig, display, plan, recording).run();
  recording.finish(recording_provenance(rig, display.info(), plan, recording, provenance));
  return summary;
}

}  // namespace fringetwin::capture
