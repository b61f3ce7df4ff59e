// SPDX-License-Identifier: Apache-2.0
// Shows patterns in a full-screen window of the desktop: pixel for pixel, at a time nobody guarantees.
#pragma once
#include <memory>
#include <string>

#include "capture/device/pattern_display.hpp"
#include "capture/display/window_module.hpp"

namespace fringetwin::capture {

/// "window" (the first screen), "window:1". Throws UserError(usage).
int parse_window_name(const std::string& text);

/// Esc or closing the window cancels, as Ctrl-C does in the terminal.
class WindowDisplay : public PatternDisplay {
 public:
  /// The screen has exactly the size given. Throws UserError.
  WindowDisplay(const std::string& name, int width, int height);

  DisplayInfo info() const override;
  Shown show(const Pattern& pattern, const ImageF& levels) override;
  void check() override;

 private:
  std::string name_;
  std::unique_ptr<Window> window_;
};

}  // namespace fringetwin::capture
