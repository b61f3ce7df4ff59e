// SPDX-License-Identifier: Apache-2.0
#include "cli/capture_rig.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "capture/simulated_rig.hpp"
#include "cli/flags.hpp"
#include "twin/errors.hpp"
#include "twin/progress.hpp"

namespace fringetwin::cli {

namespace {

constexpr const char* kTwinPrefix = "twin:";

capture::RigCamera rig_camera(const Camera& camera, std::unique_ptr<capture::CameraDevice> device) {
  return {camera.name, camera.sensor.bit_depth, std::move(device)};
}

/// The twin that stands in for the rig, showing the sequence of the twin to be recorded.
Twin stand_in(const Twin& twin, const std::string& file) {
  Twin rig = load_renderable_twin(file);
  check_renderable(rig);
  std::vector<Camera> cameras;
  for (const Camera& wanted : twin.cameras) {
    const auto it = std::find_if(rig.cameras.begin(), rig.cameras.end(),
                                 [&](const Camera& camera) { return camera.name == wanted.name; });
    if (it == rig.cameras.end())
      throw UserError(ExitCode::usage, file, fmt::format("has no camera \"{}\"", wanted.name),
                      "the twin that stands in for the rig needs the cameras of the twin to be recorded");
    cameras.push_back(*it);
  }
  rig.cameras = std::move(cameras);
  rig.fringes = twin.fringes;
  return rig;
}

OpenedRig open_simulated(const Twin& twin, const std::string& file, const RigFlags& flags) {
  if (!flags.display.empty())
    throw UserError(ExitCode::usage, "--display", "and --camera twin:TWIN.toml exclude each other",
                    "a simulated rig has its own projector");
  const Twin rig = stand_in(twin, file);
  RenderOptions options = rig.render;
  apply_flags(flags.render, options);
  const render::Sampling sampling = render::choose_sampling(rig, options);
  render::Renderer renderer(flags.render.device);
  capture::SimulatedOptions simulated;
  simulated.seed = flags.render.seed;
  simulated.latency_ms = flags.simulated_latency_ms;
  say(fmt::format("renders what the rig of {} will see", file));
  const capture::SimulatedRig devices(rig, sampling, renderer, simulated);
  OpenedRig opened;
  for (std::size_t c = 0; c < twin.cameras.size(); ++c)
    opened.cameras.push_back(rig_camera(twin.cameras[c], devices.camera(c)));
  opened.display = devices.display();
  return opened;
}

}  // namespace

void add_rig_flags(CLI::App& sub, RigFlags& flags) {
  sub.add_option("--camera", flags.cameras,
                 "[NAME=]DEVICE, e.g. left=/dev/video0, once per camera; or twin:TWIN.toml: a simulated rig");
  sub.add_option("--display", flags.display,
                 "The projector: kms[:CARD[:CONNECTOR]], window[:N], v4l2:DEVICE; several with +");
  add_render_flags(sub, flags.render);
  sub.add_option("--simulated-latency-ms", flags.simulated_latency_ms,
                 "twin: from a pattern's showing until its light")
      ->capture_default_str();
}

OpenedRig open_rig(const Twin& twin, const RigFlags& flags) {
  if (flags.cameras.empty())
    throw UserError(ExitCode::usage, "capture", "no camera given",
                    "add --camera left=/dev/video0, or --camera twin:TWIN.toml for a rehearsal");
  const auto simulated = std::find_if(flags.cameras.begin(), flags.cameras.end(),
                                      [](const std::string& c) { return c.starts_with(kTwinPrefix); });
  if (simulated == flags.cameras.end())
    throw UserError(ExitCode::usage, "--camera " + flags.cameras.front(), "is no device",
                    "use twin:TWIN.toml");
  if (flags.cameras.size() > 1)
    throw UserError(ExitCode::usage, "--camera " + *simulated, "and other cameras exclude each other",
                    "one twin:TWIN.toml serves all cameras");
  return open_simulated(twin, simulated->substr(std::string(kTwinPrefix).size()), flags);
}

}  // namespace fringetwin::cli
