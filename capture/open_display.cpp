// SPDX-License-Identifier: Apache-2.0
#include "capture/open_display.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "capture/display/kms_card.hpp"
#include "capture/display/kms_display.hpp"
#include "capture/display/mirror_display.hpp"
#include "capture/display/window_display.hpp"
#include "capture/v4l2/v4l2_display.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::capture {
namespace {

template <class Display>
std::unique_ptr<PatternDisplay> make_display(const std::string& name, int width, int height) {
  return std::make_unique<Display>(name, width, height);
}

// "v4l2:/dev/video1", with a format where the deepest is not wanted: "v4l2:/dev/video1@GREY".
std::unique_ptr<PatternDisplay> make_v4l2_display(const std::string& name, int width, int height) {
  V4l2DisplayOptions options;
  const std::size_t colon = name.find(':'), at = std::min(name.find('@'), name.size());
  if (colon < at) options.device = name.substr(colon + 1, at - colon - 1);
  if (options.device.empty())
    throw UserError(ExitCode::usage, "display", fmt::format("'{}' names no device", name),
                    "write e.g. v4l2:/dev/video1");
  if (at < name.size()) options.format.format = required_pixel_format(name.substr(at + 1), "display " + name);
  options.format.width = width;
  options.format.height = height;
  return std::make_unique<V4l2Display>(options);
}

std::unique_ptr<PatternDisplay> open_one(const std::string& name, int width, int height,
                                         const DisplayFactories& factories) {
  const auto found = factories.find(name.substr(0, name.find_first_of(":@")));
  if (found != factories.end()) return found->second(name, width, height);
  std::vector<std::string> kinds;
  for (const auto& kind : factories) kinds.push_back(kind.first);
  throw UserError(ExitCode::usage, "display",
                  fmt::format("'{}' is none of the kinds of display ({})", name, fmt::join(kinds, ", ")),
                  "write e.g. kms, kms:/dev/dri/card0:HDMI-A-1 or window:1");
}

void list_card(const std::string& path, std::vector<DisplayChoice>* list) {
  try {
    const auto card = KmsCard::open(path);
    for (const KmsHead& head : card->heads())
      list->push_back({fmt::format("kms:{}:{}", path, head.facts.name),
                       head.facts.connected
                           ? fmt::format("{}; {}", card->driver(), mode_list(head.facts.modes))
                           : "not connected"});
  } catch (const UserError& error) {
    list->push_back({"kms:" + path, error.what()});
  }
}

void list_screens(std::vector<DisplayChoice>* list) {
  try {
    std::string fault;
    const std::vector<Screen> screens = window_module().screens(&fault);
    if (!fault.empty()) list->push_back({"window", fmt::format("no desktop: {}", fault)});
    for (std::size_t i = 0; i < screens.size(); ++i)
      list->push_back({fmt::format("window:{}", i),
                       fmt::format("{}; {}x{}{}", screens[i].name, screens[i].width, screens[i].height,
                                   screens[i].refresh_hz ? fmt::format("@{}", screens[i].refresh_hz) : "")});
  } catch (const UserError& error) {
    list->push_back({"window", error.what()});
  }
}

}  // namespace

const DisplayFactories& display_factories() {
  static const DisplayFactories factories{{"kms", make_display<KmsDisplay>},
                                          {"v4l2", make_v4l2_display},
                                          {"window", make_display<WindowDisplay>}};
  return factories;
}

std::unique_ptr<PatternDisplay> open_display(const std::string& names, int width, int height,
                                             const DisplayFactories& factories) {
  std::vector<std::unique_ptr<PatternDisplay>> displays;
  for (std::size_t begin = 0; begin <= names.size();) {
    const std::size_t end = std::min(names.find('+', begin), names.size());
    displays.push_back(open_one(names.substr(begin, end - begin), width, height, factories));
    begin = end + 1;
  }
  if (displays.size() == 1) return std::move(displays.front());
  return std::make_unique<MirrorDisplay>(std::move(displays));
}

std::vector<DisplayChoice> list_displays() {
  std::vector<DisplayChoice> list;
  for (const std::string& card : kms_cards()) list_card(card, &list);
  list_screens(&list);
  return list;
}

}  // namespace fringetwin::capture
