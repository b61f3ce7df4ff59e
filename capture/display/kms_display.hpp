// SPDX-License-Identifier: Apache-2.0
// Shows patterns on a display that no desktop holds: page flips of the kernel (DRM/KMS), stamped by the
// driver.
#pragma once
#include <memory>
#include <string>

#include "capture/device/pattern_display.hpp"
#include "capture/display/page_flips.hpp"

namespace fringetwin::capture {

/// The display as it was is restored in the destructor.
class KmsDisplay : public PatternDisplay {
 public:
  /// `name` as parse_kms_name reads it; the mode has exactly the size given. Throws UserError.
  KmsDisplay(const std::string& name, int width, int height);
  ~KmsDisplay() override;

  DisplayInfo info() const override;
  /// `at_ns` is when the first line of the pattern goes out; the last line follows within a period.
  Shown show(const Pattern& pattern, const ImageF& levels) override;
  void check() override;

  const PageFlips& flips() const;

 private:
  struct Hardware;
  std::unique_ptr<Hardware> hardware_;
};

}  // namespace fringetwin::capture
