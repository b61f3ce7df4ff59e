// SPDX-License-Identifier: Apache-2.0
// The border between the program and its module that knows SDL2: full-screen windows that show gray images.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"

namespace fringetwin::capture {

struct Screen {
  std::string name;
  int width = 0, height = 0;  ///< as the desktop counts; Window::width() counts pixels
  int refresh_hz = 0;         ///< 0: not known
};

class Window {
 public:
  virtual ~Window() = default;
  virtual int width() const = 0;  ///< pixels
  virtual int height() const = 0;
  virtual std::string description() const = 0;  ///< video driver and renderer, for the record
  /// 8-bit levels, of the window's size; on the screen (as far as the desktop tells) when it returns. The
  /// window stays alive by itself. False with the reason when it cannot be shown.
  virtual bool present(const ImageU8& gray, std::string* fault) = 0;
  virtual bool gone() const = 0;    ///< with the whole desktop
  virtual bool closed() const = 0;  ///< by the user: Esc, or the desktop's way
};

/// The module's only object. Nothing of it throws; `fault` says why there is no answer.
class WindowModule {
 public:
  virtual ~WindowModule() = default;
  virtual std::vector<Screen> screens(std::string* fault) = 0;
  virtual std::unique_ptr<Window> open(int screen, std::string* fault) = 0;
};

/// The module's only function, by this name.
using WindowModuleFunction = WindowModule* (*)();
constexpr const char* kWindowModuleName =
    "fringetwin_window_module_1";  ///< 1: the classes as they stand here

/// Throws UserError(device) when the module is not found.
WindowModule& window_module();

}  // namespace fringetwin::capture
