// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "capture/grab.hpp"

namespace fringetwin::capture {

/// Starts all cameras for its life.
class Streams {
 public:
  explicit Streams(const Rig& rig) : rig_(rig) { start(); }
  ~Streams() { stop(); }
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;
  void restart() {
    stop();
    start();
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

/// An even field of the display's size.
inline Shown show_even(PatternDisplay& display, double level, const std::string& label) {
  const DisplayInfo info = display.info();
  return display.show(even_field(level, label), ImageF(info.width, info.height, static_cast<float>(level)));
}

}  // namespace fringetwin::capture
