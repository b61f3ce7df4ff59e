// SPDX-License-Identifier: Apache-2.0
// Chooses for each camera the longest exposure that the projector's brightest light does not saturate:
// modulation grows with it.
#pragma once
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"
#include "capture/device/pattern_display.hpp"

namespace fringetwin::capture {

struct ExposureOptions {
  double saturated_share = 0.001;     ///< of the pixels, at most
  std::optional<double> max_ms = {};  ///< besides the device's own limit
  std::optional<double> unit_ms =
      {};                   ///< exposures are multiples of it: the projector's frame, against flicker
  double latency_ms = 0.0;  ///< from Shown::at_ns until the light has changed
  int settle_frames = 4;    ///< after every change of light or exposure
  int frames = 2;           ///< looked at, per exposure tried
  std::chrono::milliseconds timeout{2000};
};

struct ExposureChoice {
  enum class Limit {
    light,     ///< longer would saturate
    least,     ///< even the least exposure saturates more than asked for
    greatest,  ///< the device, or max_ms, allows no more
  };
  std::string camera;
  double exposure_ms = 0.0;      ///< as read back; the device is left so
  double saturated_share = 0.0;  ///< there
  double level_dn = 0.0;         ///< all but saturated_share of the pixels lie below
  double full_scale_dn = 0.0;
  Limit limit = Limit::light;
  int tries = 0;
  bool too_dark() const { return limit == Limit::greatest && level_dn < 0.25 * full_scale_dn; }
  std::string text() const;  ///< one line, with what to do
};

/// Shows white and chooses for each camera by itself. Throws UserError(device) for a camera without exposure
/// control, DeviceFault.
std::vector<ExposureChoice> choose_exposures(const Rig& rig, PatternDisplay& display,
                                             const ExposureOptions& options = {});

}  // namespace fringetwin::capture
