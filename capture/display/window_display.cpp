// SPDX-License-Identifier: Apache-2.0
#include "capture/display/window_display.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "twin/base/errors.hpp"
#include "twin/base/module_loader.hpp"
#include "twin/base/progress.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::capture {
namespace {

UserError no_window(const std::string& name, const std::string& fault) {
  return {ExitCode::device, name, fmt::format("a window cannot be opened ({})", fault),
          "run in a desktop session (`fringetwin capture --list` shows its screens), or use 'kms' on a text "
          "console"};
}

}  // namespace

WindowModule& window_module() {
  static const auto function = reinterpret_cast<WindowModuleFunction>(
      find_in_module("libfringetwin_window.so", kWindowModuleName,
                     {ExitCode::device, "window", "opens windows",
                      "put it beside the program, or use the display 'kms' on a text console"}));
  return *function();
}

int parse_window_name(const std::string& text) {
  constexpr std::string_view kKind = "window";
  if (text == kKind) return 0;
  const int screen = text.starts_with("window:")
                         ? parse_number<int>(std::string_view(text).substr(kKind.size() + 1)).value_or(-1)
                         : -1;
  if (screen < 0) throw UserError(ExitCode::usage, text, "is no screen", "write window, or window:1");
  return screen;
}

WindowDisplay::WindowDisplay(const std::string& name, int width, int height) : name_(name) {
  const int screen = parse_window_name(name);
  std::string fault;
  window_ = window_module().open(screen, &fault);
  if (!window_) throw no_window(name, fault);
  if (window_->width() != width || window_->height() != height)
    throw UserError(ExitCode::device, name,
                    fmt::format("the screen has {}x{} pixels, the projector {}x{}", window_->width(),
                                window_->height(), width, height),
                    "patterns are never scaled: set the desktop's resolution to the projector's own, without "
                    "scaling, or correct the twin's projector");
  say(fmt::format("{}: a window shows patterns at a time nobody guarantees; KMS on a text console does",
                  name));
}

DisplayInfo WindowDisplay::info() const {
  return {name_,
          window_->width(),
          window_->height(),
          8,
          false,
          {{"driver", window_->description()}, {"timing", "not guaranteed: a window"}}};
}

void WindowDisplay::check() {
  if (window_->closed()) throw Cancelled();
  if (window_->gone())
    throw DeviceFault(DeviceFault::Kind::gone, fmt::format("{}: the desktop has ended", name_));
}

Shown WindowDisplay::show(const Pattern&, const ImageF& levels) {
  check();
  const ImageU16 quantised = quantise_levels(levels, 8);
  ImageU8 gray(quantised.width, quantised.height);
  std::transform(quantised.data.begin(), quantised.data.end(), gray.data.begin(),
                 [](std::uint16_t level) { return static_cast<unsigned char>(level); });
  FT_CHECK(gray.width == window_->width() && gray.height == window_->height(),
           "a pattern has the display's size");
  std::string fault;
  if (!window_->present(gray, &fault))
    throw DeviceFault(window_->gone() ? DeviceFault::Kind::gone : DeviceFault::Kind::stream,
                      fmt::format("{}: {}", name_, fault));
  check();
  return {steady_now_ns(), 0, false};
}

}  // namespace fringetwin::capture
