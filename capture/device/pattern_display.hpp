// SPDX-License-Identifier: Apache-2.0
// The interface of the projector as the recording sees it: a screen of fixed size that shows a pattern and
// says since when.
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "capture/device/camera_device.hpp"
#include "capture/device/pattern.hpp"

namespace fringetwin::capture {

/// The time at which a pattern came on.
struct Shown {
  TimeNs at_ns = 0;            ///< of the page flip where `timed`, else when it was handed over
  std::uint64_t sequence = 0;  ///< the display's own count of refreshes or buffers; 0 where it has none
  bool timed = false;          ///< at_ns and sequence come from the display, not from this program
};

struct DisplayInfo {
  std::string device;  ///< as the user named it, e.g. "kms:/dev/dri/card0"
  int width = 0, height = 0;
  int bit_depth = 8;
  bool timed = false;
  std::map<std::string, std::string> provenance;  ///< driver, connector, mode, refresh rate
  std::optional<double> frame_ms = {};            ///< between refreshes, where the display says
};

class PatternDisplay {
 public:
  virtual ~PatternDisplay() = default;
  virtual DisplayInfo info() const = 0;
  /// Shows `levels` (fraction of full scale, of the display's size) pixel for pixel until the next call and
  /// returns once it is on (timed) or handed over. Throws DeviceFault(gone), DeviceFault(stream).
  virtual Shown show(const Pattern& pattern, const ImageF& levels) = 0;
  /// Is called during long waits between patterns. Throws DeviceFault(gone) when the display was unplugged,
  /// Cancelled when the user closed the window.
  virtual void check() {}
};

}  // namespace fringetwin::capture
