// SPDX-License-Identifier: Apache-2.0
#include "cli/capture_rig.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "capture/device/channel_camera.hpp"
#include "capture/genicam/genicam_camera.hpp"
#include "capture/genicam/genicam_list.hpp"
#include "capture/open_display.hpp"
#include "capture/rehearse/simulated_rig.hpp"
#include "capture/v4l2/v4l2_camera.hpp"
#include "cli/option_groups.hpp"
#include "cli/render_flags.hpp"
#include "compare/result/provenance.hpp"
#include "cosim/load.hpp"
#include "cosim/other_noise.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTwinPrefix = "twin:";

/// The device under the twin's name; of one that delivers the whole sensor of a channel, its pixels alone.
capture::RigCamera rig_camera(const Camera& camera, std::unique_ptr<capture::CameraDevice> device) {
  const capture::CameraInfo info = device->info();
  if (camera.channel && (info.width != camera.lens.width() || info.height != camera.lens.height()))
    device = std::make_unique<capture::ChannelCamera>(std::move(device), *camera.channel);
  return {camera.name, camera.sensor.bit_depth, std::move(device)};
}

std::string mosaic_of(const Camera& camera) { return camera.channel ? camera.channel->mosaic : ""; }

void warn_of_raw_mosaic(const Camera& camera, const std::string& device, const capture::CameraInfo& info) {
  if (!camera.channel && info.provenance.contains("mosaic"))
    warn(fmt::format(
        "{}: the images are the raw mosaic of a colour sensor, and the twin's camera \"{}\" has none: "
        "say mosaic and channel in [camera.sensor]",
        device, camera.name));
}

/// The twin that stands in for the rig, showing the sequence of the twin to be recorded.
Twin stand_in(const Twin& twin, const std::string& file) {
  Twin rig = cosim::load_renderable_twin(file);
  cosim::check_renderable(rig);
  std::vector<Camera> cameras;
  for (const Camera& wanted : twin.cameras) {
    const auto it = std::ranges::find(rig.cameras, wanted.name, &Camera::name);
    if (it == rig.cameras.end())
      throw UserError(ExitCode::usage, file, fmt::format("has no camera \"{}\"", wanted.name),
                      "the twin that stands in for the rig needs the cameras of the twin to be recorded");
    if (it->channel && it->channel != wanted.channel)
      throw UserError(
          ExitCode::usage, file,
          fmt::format("shows the colour \"{}\" of a sensor {} as camera \"{}\", the twin to be recorded {}",
                      name_of(it->channel->colour), it->channel->mosaic, wanted.name,
                      wanted.channel ? fmt::format("\"{}\" of {}", name_of(wanted.channel->colour),
                                                   wanted.channel->mosaic)
                                     : "no colour"),
          "give both the same mosaic and channel in [camera.sensor]");
    cameras.push_back(*it);
  }
  rig.cameras = std::move(cameras);
  rig.fringes = twin.fringes;
  return rig;
}

OpenedRig open_simulated(const Twin& twin, const std::string& file, const RigFlags& flags) {
  if (!flags.trigger_line().empty())
    throw UserError(ExitCode::usage, "--trigger " + flags.trigger,
                    "and --camera twin:TWIN.toml exclude each other", "a simulated rig has no lines");
  if (!flags.display.empty())
    throw UserError(ExitCode::usage, "--display", "and --camera twin:TWIN.toml exclude each other",
                    "a simulated rig has its own projector");
  const Twin rig = stand_in(twin, file);
  const render::Sampling sampling = render::choose_sampling(rig, cosim::render_options(rig, flags.render));
  render::Renderer renderer(flags.render.device);
  capture::SimulatedOptions simulated{.seed = flags.render.seed.value_or(cosim::kDefaultSeed),
                                      .latency_ms = flags.simulated_latency_ms};
  say(fmt::format("renders what the rig of {} will see", file));
  const capture::SimulatedRig devices(rig, sampling, renderer, simulated);
  OpenedRig opened;
  for (std::size_t c = 0; c < twin.cameras.size(); ++c)
    opened.cameras.push_back(rig_camera(twin.cameras[c], devices.camera(c)));
  opened.display = devices.display();
  for (const auto& [input, digest] : compare::sha256_of_files(rig.input_files))
    opened.identity["rig " + fs::path(input).filename().string()] = digest;
  opened.identity["seed"] = std::to_string(simulated.seed);
  return opened;
}

/// "NAME=DEVICE", or "DEVICE" where the twin has one camera.
std::string device_of(const Camera& camera, const Twin& twin, const RigFlags& flags) {
  for (const std::string& text : flags.cameras) {
    if (text.starts_with(camera.name + "=")) return text.substr(camera.name.size() + 1);
    if (twin.cameras.size() == 1 && flags.cameras.size() == 1 && text.find('=') == std::string::npos)
      return text;
  }
  throw UserError(ExitCode::usage, fmt::format("--camera {}", fmt::join(flags.cameras, " --camera ")),
                  fmt::format("names no device for camera \"{}\" of the twin", camera.name),
                  fmt::format("add --camera {}=/dev/video0", camera.name));
}

void check_camera_names(const Twin& twin, const RigFlags& flags) {
  for (const std::string& text : flags.cameras) {
    const auto equal = text.find('=');
    if (equal == std::string::npos) continue;
    const std::string name = text.substr(0, equal);
    if (std::ranges::none_of(twin.cameras, [&](const Camera& camera) { return camera.name == name; }))
      throw UserError(ExitCode::usage, "--camera " + text,
                      fmt::format("the twin has no camera \"{}\"", name));
  }
}

/// "[CAMERA:]KEY=VALUE" of the options that hold for this camera.
std::vector<std::pair<std::string, std::string>> controls_of(const Camera& camera, const Twin& twin,
                                                             const RigFlags& flags) {
  std::vector<std::pair<std::string, std::string>> controls;
  for (const std::string& text : flags.controls) {
    std::string rest = text;
    bool others = false;
    for (const Camera& other : twin.cameras)
      if (text.starts_with(other.name + ":")) {
        rest = text.substr(other.name.size() + 1);
        others = other.name != camera.name;
      }
    const auto equal = rest.find('=');
    if (equal == std::string::npos || equal == 0)
      throw UserError(ExitCode::usage, "--control " + text, "is not [CAMERA:]NAME=VALUE",
                      "write e.g. --control gamma=100");
    if (!others) controls.emplace_back(rest.substr(0, equal), rest.substr(equal + 1));
  }
  return controls;
}

std::unique_ptr<capture::CameraDevice> open_v4l2(const Camera& camera, const std::string& device,
                                                 const Twin& twin, const RigFlags& flags) {
  if (!flags.trigger_line().empty())
    throw UserError(ExitCode::usage, fmt::format("--camera {}={}", camera.name, device),
                    fmt::format("a V4L2 camera cannot be triggered by {}", flags.trigger),
                    "use a GenICam camera, or leave --trigger out and add --display");
  capture::V4l2CameraOptions options;
  options.device = device;
  if (!flags.format.empty()) options.format.format = capture::required_pixel_format(flags.format, "--format");
  options.format.width = camera.sensor_px().x();
  options.format.height = camera.sensor_px().y();
  options.format.mosaic = mosaic_of(camera);
  options.format.rate_hz = flags.rate_hz;
  options.format.shift = flags.shift;
  options.gain = flags.gain;
  options.controls = controls_of(camera, twin, flags);
  options.buffers = flags.buffers;
  auto opened = std::make_unique<capture::V4l2Camera>(options);
  const auto provenance = opened->info().provenance;
  if (const auto range = provenance.find("range"); range != provenance.end())
    warn(fmt::format("{}: the driver says that its values are {}; prefer GREY or a deeper format", device,
                     range->second));
  warn_of_raw_mosaic(camera, device, opened->info());
  return opened;
}

/// Pulses do not wait for the program, so that a whole run has room, within reason.
unsigned buffers_for_run(const Fringes& fringes) {
  constexpr std::size_t kMost = 64, kSpare = 8;
  return static_cast<unsigned>(std::min(expand_sequence(fringes).size() + kSpare, kMost));
}

std::unique_ptr<capture::CameraDevice> open_genicam(const Camera& camera, const std::string& device,
                                                    const Twin& twin, const RigFlags& flags) {
  capture::GenicamCameraOptions options;
  options.name = device;
  options.format = flags.format;
  options.stored_bits = camera.sensor.bit_depth;
  options.width = camera.sensor_px().x();
  options.height = camera.sensor_px().y();
  options.mosaic = mosaic_of(camera);
  options.rate_hz = flags.rate_hz;
  options.shift = flags.shift;
  options.gain = flags.gain;
  options.controls = controls_of(camera, twin, flags);
  if (flags.trigger == "off") options.trigger = capture::GenicamTrigger::off;
  options.buffers = flags.buffers;
  if (!flags.trigger_line().empty()) {
    options.trigger = capture::GenicamTrigger::line;
    options.trigger_line = flags.trigger;
    options.buffers = std::max(options.buffers, buffers_for_run(twin.fringes));
  }
  std::map<std::string, std::string> provenance;
  auto opened = capture::open_genicam(device, &provenance);
  auto made = std::make_unique<capture::GenicamCamera>(options, std::move(opened), provenance);
  const capture::CameraInfo info = made->info();
  warn_of_raw_mosaic(camera, device, info);
  if (!info.triggered && info.pulse_line.empty() && flags.trigger != "off")
    say(fmt::format("{}: has no software trigger, frames come by themselves", device));
  return made;
}

OpenedRig open_devices(const Twin& twin, const RigFlags& flags) {
  const bool pulsed = !flags.trigger_line().empty();
  if (flags.display.empty() && !pulsed)
    throw UserError(ExitCode::usage, "capture", "no display given",
                    "add --display kms, --display window:1 (a second screen) or --display v4l2:DEVICE");
  check_camera_names(twin, flags);
  OpenedRig opened;
  for (const Camera& camera : twin.cameras) {
    const std::string device = device_of(camera, twin, flags);
    const bool genicam = device.starts_with(capture::kGenicamPrefix);
    opened.cameras.push_back(rig_camera(camera, genicam ? open_genicam(camera, device, twin, flags)
                                                        : open_v4l2(camera, device, twin, flags)));
  }
  opened.identity = {{"format", flags.format},
                     {"shift", std::to_string(flags.shift)},
                     {"gain", flags.gain ? std::to_string(*flags.gain) : ""},
                     {"rate", flags.rate_hz ? fmt::format("{}", *flags.rate_hz) : ""},
                     {"control", fmt::format("{}", fmt::join(flags.controls, " "))}};
  // A line as the camera spells it, which takes any case of its letters.
  const std::string line = opened.cameras.front().device->info().pulse_line;
  if (!flags.trigger.empty()) opened.identity["trigger"] = line.empty() ? flags.trigger : line;
  if (pulsed) return opened;
  const Lens& projector = twin.projector->lens;
  opened.display = capture::open_display(flags.display, projector.width(), projector.height());
  if (!opened.display->info().timed)
    say("the display does not say when a pattern came on: see `capture --calibrate-latency`");
  return opened;
}

void add_device_flags(CLI::App& sub, RigFlags& flags) {
  sub.add_option(
         "--format", flags.format,
         "Pixel format: GREY, Y10, Y12, Y16, Y16-BE, YUYV, MJPG, SRGGB8 ...; of GenICam cameras: Mono8, "
         "Mono12p, BayerRG8 ...")
      ->type_name("NAME")
      ->default_str(
          "the deepest of the twin's mosaic, or monochrome; of GenICam cameras that of the twin's depth "
          "first");
  sub.add_option(
         "--trigger", flags.trigger,
         "GenICam cameras: software, each frame is asked for; off, frames come by themselves; or a line "
         "of the camera, e.g. Line0, whose pulses a projector that runs by itself sends")
      ->type_name("NAME")
      ->default_str("software");
  sub.add_option("--rate", flags.rate_hz, "Frames per second")
      ->type_name("HZ")
      ->default_str("as the camera stands");
  sub.add_option("--gain", flags.gain, "Gain, in the camera's own units")
      ->type_name("N")
      ->default_str("as the camera stands");
  sub.add_option("--control", flags.controls, "[CAMERA:]NAME=VALUE: any other control; once per control")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  sub.add_option("--shift", flags.shift,
                 "Lowest bits of a word that carry nothing (12 bit values in the high bits of Y16: 4)")
      ->type_name("BITS")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
  sub.add_option("--buffers", flags.buffers, "Frames that the driver may hold")
      ->type_name("N")
      ->check(CLI::Range(2, 32))
      ->capture_default_str();
}

}  // namespace

bool RigFlags::simulated() const {
  return std::ranges::any_of(cameras, [](const std::string& c) { return c.starts_with(kTwinPrefix); });
}

void add_rig_flags(CLI::App& sub, RigFlags& flags) {
  begin_group(sub, "Rig");
  sub.add_option(
         "--camera", flags.cameras,
         "[NAME=]DEVICE, e.g. left=/dev/video0 or left=genicam:SERIAL, once per camera; or twin:TWIN.toml: a "
         "simulated rig")
      ->type_name("DEVICE")
      ->allow_extra_args(false);
  sub.add_option("--display", flags.display,
                 "The projector: kms[:CARD[:CONNECTOR]], window[:N], v4l2:DEVICE; several with +")
      ->type_name("NAME");
  begin_group(sub, "Cameras");
  add_device_flags(sub, flags);
  begin_group(sub, "Rehearsal with twin:TWIN.toml");
  sub.add_option("--simulated-latency-ms", flags.simulated_latency_ms,
                 "twin: from a pattern's showing until its light")
      ->type_name("MS")
      ->capture_default_str();
  add_render_flags(sub, flags.render);
}

OpenedRig open_rig(const Twin& twin, const RigFlags& flags) {
  if (flags.cameras.empty())
    throw UserError(
        ExitCode::usage, "capture", "no camera given",
        "add --camera left=/dev/video0 or left=genicam:SERIAL, or --camera twin:TWIN.toml for a rehearsal");
  const auto simulated =
      std::ranges::find_if(flags.cameras, [](const std::string& c) { return c.starts_with(kTwinPrefix); });
  if (simulated == flags.cameras.end()) return open_devices(twin, flags);
  if (flags.cameras.size() > 1)
    throw UserError(ExitCode::usage, "--camera " + *simulated, "and other cameras exclude each other",
                    "one twin:TWIN.toml serves all cameras");
  return open_simulated(twin, simulated->substr(std::string(kTwinPrefix).size()), flags);
}

}  // namespace fringetwin::cli
