// SPDX-License-Identifier: Apache-2.0
// Shows one pattern on several displays of one size, for example one that is seen and one that is recorded.
#pragma once
#include <memory>
#include <vector>

#include "capture/device/pattern_display.hpp"

namespace fringetwin::capture {

class MirrorDisplay : public PatternDisplay {
 public:
  /// Throws UserError(device) when their sizes differ.
  explicit MirrorDisplay(std::vector<std::unique_ptr<PatternDisplay>> displays);

  DisplayInfo info() const override;
  /// The latest of them; timed if all are.
  Shown show(const Pattern& pattern, const ImageF& levels) override;
  void check() override;

 private:
  std::vector<std::unique_ptr<PatternDisplay>> displays_;
};

}  // namespace fringetwin::capture
