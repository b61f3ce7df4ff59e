// SPDX-License-Identifier: Apache-2.0
// Opens the devices that `capture` works with, from its options: V4L2 and GenICam cameras and a projector, or
// a twin's.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"
#include "capture/device/pattern_display.hpp"
#include "cosim/simulate.hpp"
#include "twin/twin.hpp"

namespace CLI {
class App;
}

namespace fringetwin::cli {

struct RigFlags {
  std::vector<std::string> cameras;  ///< "[NAME=]DEVICE", or one "twin:TWIN.toml" for all
  std::string display;  ///< "kms…", "window…", "v4l2:DEVICE", several with '+'; none with twin:
  std::string format;   ///< "" = chosen among those offered
  std::string trigger;  ///< of GenICam cameras: "software", "off", or a line, "Line0"
  std::optional<double> rate_hz;
  std::optional<std::int64_t> gain;
  std::vector<std::string> controls;  ///< "[NAME:]KEY=VALUE"
  int shift = 0;
  unsigned buffers = 8;
  cosim::RenderRequest render;  ///< with twin:
  double simulated_latency_ms = 20.0;

  /// Returns whether a twin's renderer stands in for the devices.
  bool simulated() const;
  /// Returns the line whose pulses begin the frames; "" for none.
  std::string trigger_line() const { return trigger == "software" || trigger == "off" ? "" : trigger; }
};

/// Adds --camera, --display and what belongs to them.
void add_rig_flags(CLI::App& sub, RigFlags& flags);

struct OpenedRig {
  capture::Rig cameras;                              ///< order of the twin's cameras
  std::unique_ptr<capture::PatternDisplay> display;  ///< none with a trigger line
  /// Options that a recording must be resumed with.
  std::map<std::string, std::string> identity = {};
};

/// Opens them. Throws UserError(usage) for options at odds with the twin, UserError(device) for what a device
/// cannot do.
OpenedRig open_rig(const Twin& twin, const RigFlags& flags);

}  // namespace fringetwin::cli
