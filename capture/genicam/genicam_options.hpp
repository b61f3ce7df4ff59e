// SPDX-License-Identifier: Apache-2.0
// What a user asks of a GenICam camera.
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::capture {

inline constexpr const char* kGenicamPrefix = "genicam:";

enum class GenicamTrigger {
  software,  ///< the program asks for each frame; without the feature: off
  off,       ///< frames come by themselves
  line,      ///< a pulse on a line begins each
};

struct GenicamCameraOptions {
  std::string name = kGenicamPrefix;  ///< "genicam:SERIAL"; nothing behind the colon: the only one
  std::string format;                 ///< "Mono12p"; "": the twin's depth, else the deepest of monochrome
  int stored_bits = 8;                ///< bit_depth of the twin's sensor
  int width = 0, height = 0;          ///< of the twin's camera; with a mosaic of its whole sensor
  std::string mosaic;                 ///< of the twin's sensor, "RGGB": only formats of it; "": none
  std::optional<double> rate_hz;
  int shift = 0;
  std::optional<std::int64_t> gain;
  std::vector<std::pair<std::string, std::string>> controls;  ///< features by name, in that order
  GenicamTrigger trigger = GenicamTrigger::software;
  unsigned buffers = 8;
  std::chrono::milliseconds ptp_wait{15'000};  ///< for a clock of the network, where it is switched on
  std::string trigger_line = {};               ///< with GenicamTrigger::line: as the camera names it, "Line0"
};

}  // namespace fringetwin::capture
