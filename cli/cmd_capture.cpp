// SPDX-License-Identifier: Apache-2.0
// capture: project the sequence, record it with every camera, leave a capture set.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "capture/adjust/exposure_choice.hpp"
#include "capture/adjust/latency.hpp"
#include "capture/adjust/preview.hpp"
#include "capture/genicam/genicam_list.hpp"
#include "capture/open_display.hpp"
#include "capture/record/journal.hpp"
#include "capture/record/pattern_files.hpp"
#include "capture/record/pulse_session.hpp"
#include "capture/record/session.hpp"
#include "capture/record/timing.hpp"
#include "capture/record/verify_set.hpp"
#include "capture/v4l2/v4l2_list.hpp"
#include "cli/capture_rig.hpp"
#include "cli/commands.hpp"
#include "cli/option_groups.hpp"
#include "cli/twin_argument.hpp"
#include "cosim/load.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

/// For a projector that runs by itself.
struct PulseFlags {
  std::optional<double> wait_s, pause_ms;
  std::string patterns;  ///< folder to write them to; "": none asked for

  capture::PulseOptions options() const {
    capture::PulseOptions options;
    if (wait_s) options.wait = std::chrono::milliseconds(std::llround(1000.0 * *wait_s));
    if (pause_ms) options.pause = std::chrono::milliseconds(std::llround(*pause_ms));
    return options;
  }
};

struct CaptureCommand {
  std::string twin, out;
  std::string verify;
  bool resume = false, overwrite = false, list = false, auto_exposure = false, calibrate_latency = false,
       preview = false;
  int preview_looks = 0;
  double saturated_share = 0.001;
  std::optional<double> exposure_unit_ms;
  int timeout_ms = 2000;
  std::optional<int> settle_frames;
  capture::CapturePlan plan;
  RigFlags rig;
  PulseFlags pulses;
  capture::Existing existing() const {
    return overwrite ? capture::Existing::overwrite
           : resume  ? capture::Existing::resume
                     : capture::Existing::refuse;
  }
};

Twin load_projected_twin(const std::string& file) {
  if (file.empty())
    throw UserError(ExitCode::usage, "capture", "no twin given", "fringetwin capture TWIN.toml --out DIR …");
  Twin twin = cosim::load_for_run(file);
  if (!twin.projector)
    throw UserError(ExitCode::usage, file, "the twin has no [projector], so there is no size of its patterns",
                    "add the projector");
  return twin;
}

void print_summary(const CaptureCommand& o, const capture::SessionSummary& summary) {
  say(fmt::format(
      "recorded {} of {} patterns in {:.1f} s; frames lost {}, repeated {}, corrupt {}; {} tried again",
      summary.recorded, summary.steps, summary.seconds, summary.lost_frames, summary.repeated_frames,
      summary.corrupt_frames, summary.retries));
  if (summary.worst_skew_ms > 0.0)
    say(fmt::format("the cameras' exposures began at most {:.2f} ms apart", summary.worst_skew_ms));
  say("capture set: " + (fs::path(o.out) / "capture.toml").string());
}

/// Settling frames cover a latency that nobody knows; a triggered camera waits for one that is known.
void choose_settling(CaptureCommand& o, const OpenedRig& rig) {
  const bool triggered = std::ranges::all_of(
      rig.cameras, [](const capture::RigCamera& camera) { return camera.device->info().triggered; });
  if (!o.settle_frames && triggered && o.plan.latency_ms > 0.0) o.plan.settle_frames = 0;
}

/// --auto-exposure and --calibrate-latency, for the recording that follows.
void prepare(CaptureCommand& o, const OpenedRig& rig, bool unfinished) {
  if (o.auto_exposure) {
    const bool kept = unfinished && restore_exposures(capture::Journal::identity(o.out), rig.cameras);
    if (kept) {
      say("exposures as the recording was begun with");
    } else {
      capture::ExposureOptions options{.saturated_share = o.saturated_share,
                                       .unit_ms = o.exposure_unit_ms,
                                       .latency_ms = o.plan.latency_ms,
                                       .timeout = o.plan.timeout};
      for (const auto& choice : choose_exposures(rig.cameras, *rig.display, options)) {
        if (choice.limit == capture::ExposureChoice::Limit::least || choice.too_dark())
          warn(choice.text());
        else
          say(choice.text());
      }
    }
  }
  if (!o.calibrate_latency) return;
  capture::LatencyOptions options{.timeout = o.plan.timeout};
  const capture::Latency latency = calibrate_latency(rig.cameras, *rig.display, options);
  for (const std::string& line : latency.lines()) fmt::print("{}\n", line);
  o.plan.latency_ms = latency.latency_ms;
  o.plan.settle_frames = latency.settle_frames;
}

/// Throws UserError(usage) for options that a projector which runs by itself makes no sense with, and for its
/// own without one.
void check_pulses(const CaptureCommand& o) {
  const std::string line = o.rig.trigger_line();
  if (line.empty()) {
    for (const auto& [option, given] :
         {std::pair{"--wait-s", o.pulses.wait_s}, std::pair{"--pause-ms", o.pulses.pause_ms}})
      if (given)
        throw UserError(ExitCode::usage, option, "is for a projector that runs by itself",
                        "add --trigger LINE, or leave it out");
    return;
  }
  const auto exclude = [&line](bool given, const char* option, const char* instead) {
    if (given)
      throw UserError(ExitCode::usage, option, fmt::format("and --trigger {} exclude each other", line),
                      instead);
  };
  exclude(!o.rig.display.empty(), "--display",
          "the projector shows the sequence by itself, load it with the pictures of --patterns");
  exclude(o.auto_exposure, "--auto-exposure", "it needs a display that shows white: set --exposure-ms");
  exclude(o.calibrate_latency, "--calibrate-latency", "the pulses say when a pattern is on");
  exclude(o.preview, "--preview", "it needs a display that shows one pattern at a time");
  exclude(o.settle_frames.has_value(), "--settle", "each pulse has one frame, and none is left out");
  capture::check_pulse_plan(o.plan, line);
}

int run_patterns(const CaptureCommand& o) {
  if (!o.out.empty() || !o.rig.cameras.empty() || !o.rig.display.empty())
    throw UserError(ExitCode::usage, "--patterns", "opens no device and records nothing",
                    "leave --out, --camera and --display out");
  check_out_folder(o.pulses.patterns);
  const Twin twin = load_projected_twin(o.twin);
  const std::size_t n = capture::write_pattern_files(twin, o.pulses.patterns, o.overwrite);
  const Lens& projector = twin.projector->lens;
  say(fmt::format("{} pictures of {} x {} px: {}", n, projector.width(), projector.height(),
                  o.pulses.patterns));
  return static_cast<int>(ExitCode::ok);
}

/// A line per camera and look, until Ctrl-C (or Esc in a window): that is its ordinary end.
int run_preview(const CaptureCommand& o) {
  const Twin twin = load_projected_twin(o.twin);
  const OpenedRig rig = open_rig(twin, o.rig);
  check_rig(twin, rig.cameras, *rig.display, o.plan);
  capture::Preview preview(twin, rig.cameras, *rig.display, o.plan);
  try {
    for (int look = 0; o.preview_looks == 0 || look < o.preview_looks; ++look) {
      for (const capture::PreviewNumbers& numbers : preview.look()) fmt::print("{}\n", numbers.text());
      std::fflush(stdout);
    }
  } catch (const Cancelled&) {
  }
  return static_cast<int>(ExitCode::ok);
}

void tell_flicker(const CaptureCommand& o, const capture::RigTiming& timing) {
  for (const std::string& sentence : flicker_warnings(timing, o.plan.exposures_ms)) warn(sentence);
}

/// Says what the recording will take, and warns of exposures that hold no whole frames of the projector.
void tell_timing(const CaptureCommand& o, const OpenedRig& rig, const Twin& twin) {
  const capture::RigTiming timing = rig_timing(rig.cameras, rig.display->info(), o.exposure_unit_ms);
  say(plan_text(timing, make_steps(twin.fringes, o.plan), o.plan));
  tell_flicker(o, timing);
}

int run_record(CaptureCommand& o, const Invocation& invocation) {
  if (o.out.empty() && (o.calibrate_latency || o.auto_exposure)) {
    const Twin twin = load_projected_twin(o.twin);
    const OpenedRig rig = open_rig(twin, o.rig);
    check_rig(twin, rig.cameras, *rig.display, o.plan);
    prepare(o, rig, false);
    return static_cast<int>(ExitCode::ok);
  }
  if (o.out.empty()) throw UserError(ExitCode::usage, "capture", "no output folder given", "add --out DIR");
  if (o.auto_exposure && !o.plan.exposures_ms.empty())
    throw UserError(ExitCode::usage, "--auto-exposure", "and --exposure-ms exclude each other");
  if (o.resume && o.overwrite)
    throw UserError(ExitCode::usage, "--resume", "and --overwrite exclude each other");
  check_out_folder(o.out);
  const Twin twin = load_projected_twin(o.twin);
  check_plan(o.plan);
  const capture::Found found = capture::Recording::look_into(o.out, twin, o.plan, o.existing());
  if (found == capture::Found::complete) {
    say("nothing left to do: " + o.out + " holds the complete set");
    return static_cast<int>(ExitCode::ok);
  }
  const OpenedRig rig = open_rig(twin, o.rig);
  if (rig.display) {
    check_rig(twin, rig.cameras, *rig.display, o.plan);
    choose_settling(o, rig);
    prepare(o, rig, found == capture::Found::unfinished);
    if (!o.rig.simulated()) tell_timing(o, rig, twin);
  } else {
    check_cameras(twin, rig.cameras, o.plan);
    tell_flicker(o, rig_timing(rig.cameras, {}, o.exposure_unit_ms));
  }
  std::map<std::string, std::string> identity = recording_identity(twin, rig.cameras, o.plan);
  identity.insert(rig.identity.begin(), rig.identity.end());
  // Only now: devices that do not fit leave an older recording as it is.
  capture::Recording recording(o.out, twin, o.plan, identity, o.existing());
  const std::map<std::string, std::string> provenance = {
      {"program", "fringetwin " + version_string()},
      {"command", fmt::format("{}", fmt::join(invocation.argv, " "))},
      {"twin", twin.name}};
  print_summary(o, rig.display
                       ? record_session(twin, rig.cameras, *rig.display, o.plan, recording, provenance)
                       : record_pulses(twin, rig.cameras, o.plan, o.pulses.options(), recording, provenance));
  return static_cast<int>(ExitCode::ok);
}

int run_verify(const CaptureCommand& o) {
  std::optional<Twin> twin;
  if (!o.twin.empty()) twin = cosim::load_for_run(o.twin);
  const capture::SetCheck check = capture::verify_set(o.verify, twin ? &*twin : nullptr);
  for (const std::string& finding : check.findings) warn(finding);
  fmt::print("{}\n", plain_text(check.summary()));
  return static_cast<int>(check.passed() ? ExitCode::ok : ExitCode::input);
}

int run_list() {
  for (const capture::V4l2Listed& listed : capture::list_v4l2_devices()) fmt::print("{}\n", describe(listed));
  for (const std::string& text : capture::list_genicam_cameras()) fmt::print("{}\n", plain_lines(text));
  for (const capture::DisplayChoice& choice : capture::list_displays())
    fmt::print("{}\t{}\n", choice.name, choice.facts);
  return static_cast<int>(ExitCode::ok);
}

int run_capture(CaptureCommand o, const Invocation& invocation) {
  o.plan.timeout = std::chrono::milliseconds(o.timeout_ms);
  if (o.settle_frames) o.plan.settle_frames = *o.settle_frames;
  if (o.list) return run_list();
  if (!o.verify.empty()) return run_verify(o);
  if (!o.pulses.patterns.empty()) return run_patterns(o);
  check_pulses(o);
  if (o.preview) return run_preview(o);
  return run_record(o, invocation);
}

void add_instead_options(CLI::App& sub, CaptureCommand& o) {
  begin_group(sub, "Instead of a recording");
  sub.add_flag("--list", o.list, "List cameras and displays");
  sub.add_flag("--preview", o.preview,
               "Print saturation, modulation, contrast and focus, again and again, until Ctrl-C");
  sub.add_option("--preview-looks", o.preview_looks, "So many times (0: until Ctrl-C)")
      ->type_name("N")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  sub.add_option("--verify", o.verify,
                 "Check a recorded set: every image whole, with its checksum (exit code 3 if not)")
      ->type_name("DIR");
}

void add_image_options(CLI::App& sub, CaptureCommand& o) {
  capture::CapturePlan& plan = o.plan;
  begin_group(sub, "Images");
  sub.add_option("--average", plan.average, "Frames averaged for one image")
      ->type_name("N")
      ->capture_default_str();
  sub.add_option("--repeats", plan.repeats, "Images of each pattern, a set each: for `photometry --captures`")
      ->type_name("N")
      ->capture_default_str();
  sub.add_flag("--references", plan.references, "White and black images besides");
  sub.add_option("--dark", plan.dark_frames, "So many frames with the projector black, into dark/")
      ->type_name("N")
      ->capture_default_str();
  sub.add_option("--flat", plan.flat_frames, "So many frames with the projector white, into flat/")
      ->type_name("N")
      ->capture_default_str();
}

void add_exposure_options(CLI::App& sub, CaptureCommand& o) {
  begin_group(sub, "Exposure");
  sub.add_option("--exposure-ms", o.plan.exposures_ms, "Exposure; several: a set each, and one merged")
      ->type_name("MS")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->default_str("as the cameras stand");
  sub.add_flag(
      "--auto-exposure", o.auto_exposure,
      "First the longest exposure that the projector's white does not saturate; without --out: that alone");
  sub.add_option("--saturated-share", o.saturated_share,
                 "Share of the pixels that --auto-exposure lets saturate")
      ->type_name("SHARE")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  sub.add_option(
         "--exposure-unit-ms", o.exposure_unit_ms,
         "The projector's frame time: --auto-exposure takes multiples of it, against flicker, and other "
         "exposures are warned of")
      ->type_name("MS")
      ->check(CLI::Range(0.1, 1000.0))
      ->default_str("as the display says; for --auto-exposure none");
}

void add_timing_options(CLI::App& sub, CaptureCommand& o) {
  capture::CapturePlan& plan = o.plan;
  begin_group(sub, "Timing");
  sub.add_option("--settle", o.settle_frames, "Frames left out after a pattern has come on")
      ->type_name("N")
      ->default_str("2; 0 with triggered cameras where --latency-ms is given");
  sub.add_option("--latency-ms", plan.latency_ms,
                 "From a pattern's showing until its light (see --calibrate-latency)")
      ->type_name("MS")
      ->capture_default_str();
  sub.add_flag("--calibrate-latency", o.calibrate_latency,
               "First measure --latency-ms and --settle from images; without --out: that alone");
  sub.add_option("--max-skew-ms", plan.max_skew_ms, "Most that the cameras' exposures may be apart")
      ->type_name("MS")
      ->default_str("one frame period");
  sub.add_option("--timeout-ms", o.timeout_ms, "For one frame, and for a lost signal to come back")
      ->type_name("MS")
      ->check(CLI::Range(1, 600'000))
      ->capture_default_str();
}

void add_pulse_flags(CLI::App& sub, PulseFlags& flags) {
  begin_group(sub, "A projector that runs by itself (--trigger LINE)");
  sub.add_option(
         "--patterns", flags.patterns,
         "Write the pictures that it is loaded with, 000.png ..., and what they are; nothing is recorded")
      ->type_name("DIR");
  sub.add_option("--wait-s", flags.wait_s, "For the first pulse of a run")
      ->type_name("S")
      ->check(CLI::Range(0.1, 86'400.0))
      ->default_str("60");
  sub.add_option("--pause-ms", flags.pause_ms, "Without a pulse, after which a run has ended")
      ->type_name("MS")
      ->check(CLI::Range(50.0, 60'000.0))
      ->default_str("500");
}

}  // namespace

void add_capture(CLI::App& app, Invocation& invocation) {
  auto o = std::make_shared<CaptureCommand>();
  CLI::App* sub = app.add_subcommand(
      "capture",
      "Project the sequence and record it: V4L2 or GenICam cameras and a projector, or a simulated rig");
  add_twin_argument(*sub, o->twin, "The twin.toml: the sequence, image sizes, bit depths");
  begin_group(*sub, kOutput);
  sub->add_option("--out", o->out, "Folder for the capture set (made if missing)")->type_name("DIR");
  sub->add_flag("--resume", o->resume, "Go on with a recording that was broken off");
  sub->add_flag("--overwrite", o->overwrite, "Replace a recording that is there already");
  add_instead_options(*sub, *o);
  add_image_options(*sub, *o);
  add_exposure_options(*sub, *o);
  add_timing_options(*sub, *o);
  add_rig_flags(*sub, o->rig);
  add_pulse_flags(*sub, o->pulses);
  run_when_chosen(*sub, invocation, o, run_capture);
}

}  // namespace fringetwin::cli
