// SPDX-License-Identifier: Apache-2.0
#include "capture/record/pulse_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "capture/record/pulses.hpp"
#include "capture/record/streams.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::capture {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// For one look at a camera: its buffers hold the frames that come while the others are looked at.
constexpr std::chrono::milliseconds kLook{20};
constexpr const char* kGivenUp = "given up";
/// Of what is free: frames that wait and images that are written need some, too.
constexpr double kShareOfMemory = 0.8;

/// What programs can have without swapping, as the kernel says; nullopt where it does not.
std::optional<double> available_memory_bytes() {
  std::ifstream file("/proc/meminfo");
  std::string name;
  for (double kilobytes = 0.0; file >> name >> kilobytes; std::getline(file, name))
    if (name == "MemAvailable:") return 1024.0 * kilobytes;
  return std::nullopt;
}

/// What came of one run of the projector, by camera.
struct PulseRun {
  std::vector<std::vector<Frame>> frames;
  bool endless = false;  ///< no pause came
};

/// The frame that waits, or comes within this time; nullopt for none.
std::optional<Frame> poll_frame(CameraDevice& camera, CameraDevice::Pixels pixels,
                                std::chrono::milliseconds look) {
  try {
    return camera.next_frame(look, pixels);
  } catch (const DeviceFault& fault) {
    if (fault.kind() != DeviceFault::Kind::timeout) throw;
    return std::nullopt;
  }
}

class PulseSession {
 public:
  PulseSession(const Twin& twin, const Rig& rig, const CapturePlan& plan, const PulseOptions& options,
               Recording& recording)
      : rig_(rig),
        plan_(plan),
        options_(options),
        recording_(recording),
        steps_(make_steps(twin.fringes, plan)),
        line_(rig.front().device->info().pulse_line) {
    summary_.steps = static_cast<int>(steps_.size());
    for (const StepRecord& record : recording.records()) run_ = std::max(run_, record.shown.sequence);
  }

  SessionSummary record() {
    const auto begin = SteadyClock::now();
    if (!has_whole_run()) record_a_run();
    recording_.flush();
    summary_.seconds = std::chrono::duration<double>(SteadyClock::now() - begin).count();
    return summary_;
  }

 private:
  std::size_t n_pulses() const { return steps_.size(); }

  /// Images of two runs do not belong into one set.
  bool has_whole_run() const {
    std::map<int, std::uint64_t> runs;
    for (const StepRecord& record : recording_.records()) runs[record.step] = record.shown.sequence;
    for (int i = 0; i < summary_.steps; ++i)
      if (!recording_.has(i) || runs.at(i) != runs.at(0)) return false;
    return true;
  }

  /// A run is judged as a whole, so its frames are in memory until then.
  void check_memory() const {
    double bytes = 0.0;
    for (const RigCamera& camera : rig_) {
      const CameraInfo info = camera.device->info();
      bytes += sizeof(std::uint16_t) * static_cast<double>(info.width) * info.height *
               static_cast<double>(n_pulses());
    }
    const std::optional<double> free_bytes = available_memory_bytes();
    if (free_bytes && bytes > kShareOfMemory * *free_bytes)
      throw UserError(
          ExitCode::device, "--trigger " + line_,
          fmt::format("a run of {} images of each camera is held in memory until it is judged: {:.1f} GB, of "
                      "which {:.1f} are free",
                      n_pulses(), 1e-9 * bytes, 1e-9 * *free_bytes),
          "record a region of the sensor (--control OffsetX=...), or a shorter sequence");
  }

  void record_a_run() {
    check_memory();
    if (!plan_.exposures_ms.empty())
      for (const RigCamera& camera : rig_) set_exposure_exactly(*camera.device, plan_.exposures_ms.front());
    Streams streams(rig_);
    for (const RigCamera& camera : rig_) camera.device->drain();
    for (int attempt = 1;; ++attempt) {
      ++run_;
      std::string fault;
      try {
        fault = try_run(attempt);
        if (fault.empty()) return;
      } catch (const DeviceFault& device) {
        if (device.kind() == DeviceFault::Kind::gone) give_up(device.what());
        fault = device.what();
        restart(streams);
      }
      if (attempt >= plan_.attempts)
        give_up(fmt::format("none of {} runs of the projector was right; in the last one {}", attempt, fault),
                "give the cameras time between two pulses (exposure and read-out), look at the line, and ");
      ++summary_.retries;
      warn(fmt::format("run {} of the projector: {}; the next run is waited for", attempt, fault));
    }
  }

  void restart(Streams& streams) const {
    try {
      streams.restart_for_next_try();
    } catch (const DeviceFault& gone) {
      give_up(gone.what());
    }
  }

  /// Returns what is wrong with the run; "" for nothing, and its images are kept.
  std::string try_run(int attempt) {
    PulseRun run = take_run();
    std::vector<PulseTrain> trains;
    for (std::size_t c = 0; c < rig_.size(); ++c) trains.push_back(train_of(rig_[c], run.frames[c]));
    const PulseVerdict verdict = judge_pulses(trains, summary_.steps);
    if (run.endless)
      give_up(fmt::format("more than {} pulses came without a pause of {} ms, the sequence has {}",
                          most_frames(), options_.pause.count(), n_pulses()),
              "let the projector play the sequence once for each start, with a rest of that length, and ");
    if (verdict.right()) {
      keep(run, trains, verdict, attempt);
      return "";
    }
    note_wrong_run(run, trains, verdict);
    const bool one_each =
        std::ranges::all_of(run.frames, [](const auto& frames) { return frames.size() == 1; });
    if (one_each && n_pulses() > 1)
      return fmt::format(
          "one pulse came, and none within {} ms after it (--pause-ms, which must be longer than "
          "from pulse to pulse)",
          options_.pause.count());
    return verdict.sentence();
  }

  // --- frames

  std::size_t most_frames() const { return 2 * n_pulses() + 10; }

  PulseRun take_run() const {
    say(fmt::format("armed; waiting for the first pulse on {}", line_));
    PulseRun run;
    run.frames.resize(rig_.size());
    const auto begin = SteadyClock::now();
    std::optional<SteadyClock::time_point> last;
    bool frames_come = false;  // then no camera that is silent keeps the others waiting
    for (;;) {
      throw_if_cancelled();
      const std::chrono::milliseconds look = frames_come ? std::chrono::milliseconds(0) : kLook;
      frames_come = false;
      for (std::size_t c = 0; c < rig_.size(); ++c) {
        // A run with too many frames is wrong: their pixels are of no use.
        const auto pixels =
            run.frames[c].size() < n_pulses() ? CameraDevice::Pixels::keep : CameraDevice::Pixels::drop;
        std::optional<Frame> frame = poll_frame(*rig_[c].device, pixels, look);
        if (!frame) continue;
        frames_come = true;
        run.frames[c].push_back(std::move(*frame));
        last = SteadyClock::now();
        run.endless = run.endless || run.frames[c].size() > most_frames();
      }
      if (run.endless || (last && SteadyClock::now() - *last > options_.pause)) break;
      if (!last && SteadyClock::now() - begin > options_.wait) nothing_came();
    }
    for (const RigCamera& camera : rig_) camera.device->check_input();
    return run;
  }

  /// By the camera's clock where it has one.
  static PulseTrain train_of(const RigCamera& camera, const std::vector<Frame>& frames) {
    const bool has_clock = std::ranges::all_of(
        frames, [](const Frame& frame) { return frame.camera_ns != 0 || frame.fault != FrameFault::none; });
    PulseTrain train{camera.name, {}, has_clock && camera.device->info().has_shared_clock};
    for (const Frame& frame : frames)
      train.frames.push_back({has_clock ? frame.camera_ns : frame.timestamp_ns, frame.sequence,
                              frame.fault == FrameFault::none ? "" : frame_fault_name(frame.fault)});
    return train;
  }

  // --- records

  FrameRecord frame_record(const PulseRun& run, const std::vector<PulseTrain>& trains, std::size_t c,
                           std::size_t i) const {
    const Frame& frame = run.frames[c][i];
    return {rig_[c].name, frame.sequence, trains[c].frames[i].camera_ns, frame.flags, kGivenUp, shown(frame)};
  }
  Shown shown(const Frame& frame) const { return {frame.timestamp_ns, run_, false}; }

  /// A frame of a wrong run stands with the pattern that its place in the run would have.
  void note_wrong_run(const PulseRun& run, const std::vector<PulseTrain>& trains,
                      const PulseVerdict& verdict) {
    wrong_frames_.resize(n_pulses());
    for (std::size_t c = 0; c < rig_.size(); ++c)
      for (std::size_t i = 0; i < run.frames[c].size(); ++i) {
        FrameRecord record = frame_record(run, trains, c, i);
        if (const std::string& fault = verdict.frame_faults[c][i]; !fault.empty()) record.use = fault;
        wrong_frames_[std::min(i, n_pulses() - 1)].push_back(std::move(record));
      }
    using Fault = PulseFault::Kind;
    summary_.lost_frames +=
        static_cast<std::uint32_t>(verdict.count(Fault::missing) + verdict.count(Fault::lost));
    summary_.repeated_frames += verdict.count(Fault::doubled);
    summary_.corrupt_frames += verdict.count(Fault::damaged);
  }

  void keep(PulseRun& run, const std::vector<PulseTrain>& trains, const PulseVerdict& verdict, int attempt) {
    say(fmt::format("{} pulses came, {:.4g} ms apart", n_pulses(), verdict.interval_ms));
    wrong_frames_.resize(n_pulses());
    Progress progress("write", n_pulses());
    for (std::size_t k = 0; k < n_pulses(); ++k) {
      const Step& step = steps_[k];
      StepRecord record;
      record.step = static_cast<int>(k);
      record.pattern = step.pattern.label;
      record.shown = shown(run.frames[0][k]);
      record.frames = std::move(wrong_frames_[k]);
      record.attempts = attempt;
      if (k == 0) {  // of all runs, which are tried as a whole
        record.lost_frames = summary_.lost_frames;
        record.repeated_frames = summary_.repeated_frames;
        record.corrupt_frames = summary_.corrupt_frames;
      }
      if (!verdict.skew_ms.empty()) record.skew_ms = verdict.skew_ms[k];
      summary_.worst_skew_ms = std::max(summary_.worst_skew_ms, record.skew_ms);
      std::vector<RecordedImage> images;
      for (std::size_t c = 0; c < rig_.size(); ++c) {
        FrameRecord frame = frame_record(run, trains, c, k);
        frame.use = step.pictures.front().name;
        frame.good = true;
        record.frames.push_back(std::move(frame));
        images.push_back(image_of(rig_[c], step, run.frames[c][k]));
      }
      recording_.store(std::move(record), std::move(images));
      ++summary_.recorded;
      progress.advance();
    }
  }

  static RecordedImage image_of(const RigCamera& camera, const Step& step, Frame& frame) {
    const CameraInfo info = camera.device->info();
    FrameAverage average(info.bit_depth, camera.stored_bits);
    average.add(std::move(frame.dn), info.device);
    return {step.pictures.front().file(camera.name), camera.stored_bits, average.stored()};
  }

  // --- ends

  [[noreturn]] void nothing_came() const {
    throw UserError(
        ExitCode::device, "--trigger " + line_,
        fmt::format("no pulse came within {:.4g} s", std::chrono::duration<double>(options_.wait).count()),
        "start the projector's sequence once the program waits, look at the cable and the line's voltage, or "
        "wait longer with --wait-s");
  }
  [[noreturn]] void give_up(const std::string& what, const std::string& hint = "") const {
    recording_.flush();
    throw UserError(ExitCode::device, "--trigger " + line_, what, hint + "take the next run with --resume");
  }

  const Rig& rig_;
  const CapturePlan& plan_;
  const PulseOptions& options_;
  Recording& recording_;
  std::vector<Step> steps_;
  std::string line_;
  SessionSummary summary_;
  std::uint64_t run_ = 0;  ///< number of the projector's run, of all that the recording has seen
  std::vector<std::vector<FrameRecord>> wrong_frames_;  ///< by step
};

void check_one(bool asked, const std::string& option, const std::string& line, const std::string& hint) {
  if (asked)
    throw UserError(ExitCode::usage, option, fmt::format("and --trigger {} exclude each other", line), hint);
}

}  // namespace

void check_pulse_plan(const CapturePlan& plan, const std::string& line) {
  check_one(plan.average > 1, "--average", line,
            "a projector that runs by itself shows each pattern for one frame: expose it for longer");
  check_one(plan.repeats > 1, "--repeats", line,
            "record the sequence again, each time into a folder of its own");
  check_one(plan.brackets(), "--exposure-ms with several exposures", line,
            "record each exposure into a folder of its own");
  check_one(
      plan.references, "--references", line,
      "the projector shows the images of --patterns, which has white and black where the twin needs them");
  check_one(plan.dark_frames > 0, "--dark", line,
            "the projector shows its sequence and nothing else: record dark frames with a display");
  check_one(plan.flat_frames > 0, "--flat", line,
            "the projector shows its sequence and nothing else: record flat frames with a display");
  check_one(
      plan.latency_ms > 0.0, "--latency-ms", line,
      "the projector pulses when a pattern is on: set a delay at the camera, --control TriggerDelay=...");
  check_one(plan.max_skew_ms.has_value(), "--max-skew-ms", line, "cameras on one line are exposed together");
}

SessionSummary record_pulses(const Twin& twin, const Rig& rig, const CapturePlan& plan,
                             const PulseOptions& options, Recording& recording,
                             const std::map<std::string, std::string>& provenance) {
  for (const RigCamera& camera : rig)
    FT_CHECK(!camera.device->info().pulse_line.empty(), "all cameras wait for pulses");
  const SessionSummary summary = PulseSession(twin, rig, plan, options, recording).record();
  DisplayInfo projector;
  projector.device = "a projector that runs by itself";
  auto all = recording_provenance(rig, projector, plan, recording, provenance);
  all["projector timing"] = "its pulses";
  all["settle frames"] = "0";
  recording.finish(all);
  return summary;
}

}  // namespace fringetwin::capture
