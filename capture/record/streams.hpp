// SPDX-License-Identifier: Apache-2.0
// Starts and stops the cameras of a rig and shows patterns, for all who use one.
#pragma once
#include "capture/device/camera_device.hpp"
#include "capture/device/pattern_display.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::capture {

/// Starts all cameras for its life.
class Streams : NotCopyable {
 public:
  explicit Streams(const Rig& rig) : rig_(rig) { start(); }
  ~Streams() { stop(); }
  void restart() {
    stop();
    start();
  }
  /// The same for another try after a fault: a device that refuses is warned about, for the next try finds no
  /// stream, and counts. Throws DeviceFault(gone).
  void restart_for_next_try() {
    try {
      restart();
    } catch (const DeviceFault& still) {
      if (still.kind() == DeviceFault::Kind::gone) throw;
    } catch (const UserError& refused) {
      warn(refused.what());
    }
  }

 private:
  void start() {
    for (const RigCamera& camera : rig_) camera.device->start();
  }
  void stop() noexcept {
    for (const RigCamera& camera : rig_) camera.device->stop();
  }
  const Rig& rig_;
};

/// Pixel for pixel on the whole display.
inline Shown show_pattern(PatternDisplay& display, const Fringes& fringes, const Pattern& pattern) {
  const DisplayInfo info = display.info();
  return display.show(pattern, pattern_levels(fringes, pattern, info.width, info.height));
}
inline Shown show_even(PatternDisplay& display, double level, const std::string& label) {
  return show_pattern(display, Fringes(), even_field(level, label));
}

}  // namespace fringetwin::capture
