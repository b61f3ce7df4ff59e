// SPDX-License-Identifier: Apache-2.0
#include "capture/display/mirror_display.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin::capture {

MirrorDisplay::MirrorDisplay(std::vector<std::unique_ptr<PatternDisplay>> displays)
    : displays_(std::move(displays)) {
  FT_CHECK(!displays_.empty(), "a mirror has displays");
  const DisplayInfo first = displays_.front()->info();
  for (const auto& display : displays_) {
    const DisplayInfo other = display->info();
    if (other.width != first.width || other.height != first.height)
      throw UserError(ExitCode::device, other.device,
                      fmt::format("has {}x{} pixels, {} has {}x{}", other.width, other.height, first.device,
                                  first.width, first.height),
                      "the displays joined by + must have one size");
  }
}

DisplayInfo MirrorDisplay::info() const {
  DisplayInfo all = displays_.front()->info();
  all.device.clear();
  all.provenance.clear();
  for (std::size_t i = 0; i < displays_.size(); ++i) {
    const DisplayInfo one = displays_[i]->info();
    all.device += (i ? "+" : "") + one.device;
    all.bit_depth = std::min(all.bit_depth, one.bit_depth);
    all.timed = all.timed && one.timed;
    if (one.frame_ms != all.frame_ms) all.frame_ms.reset();  // no one number
    for (const auto& [key, value] : one.provenance) all.provenance[fmt::format("{}.{}", i + 1, key)] = value;
  }
  return all;
}

Shown MirrorDisplay::show(const Pattern& pattern, const ImageF& levels) {
  Shown latest;
  bool timed = true;
  for (std::size_t i = 0; i < displays_.size(); ++i) {
    const Shown shown = displays_[i]->show(pattern, levels);
    timed = timed && shown.timed;
    if (i == 0 || shown.at_ns > latest.at_ns) latest = shown;
  }
  latest.timed = timed;
  return latest;
}

void MirrorDisplay::check() {
  for (const auto& display : displays_) display->check();
}

}  // namespace fringetwin::capture
