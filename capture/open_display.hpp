// SPDX-License-Identifier: Apache-2.0
// Opens displays by the names that users write, and lists those there are.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "capture/device/pattern_display.hpp"

namespace fringetwin::capture {

/// Opens the display of that name, of exactly that size.
using DisplayFactory =
    std::function<std::unique_ptr<PatternDisplay>(const std::string& name, int width, int height)>;
/// What opens a kind of display, by the word before the first ':' or '@' of a name.
using DisplayFactories = std::map<std::string, DisplayFactory>;

/// "kms", "window", "v4l2".
const DisplayFactories& display_factories();

/// "window:1", "kms:/dev/dri/card0:HDMI-A-1@60", or several joined by '+'. Throws UserError.
std::unique_ptr<PatternDisplay> open_display(const std::string& names, int width, int height,
                                             const DisplayFactories& factories = display_factories());

struct DisplayChoice {
  std::string name;   ///< for open_display
  std::string facts;  ///< driver and modes, or why it cannot be used
};
/// Cards with their connectors, and the desktop's screens. Never throws; what cannot be looked at says why.
std::vector<DisplayChoice> list_displays();

}  // namespace fringetwin::capture
