// SPDX-License-Identifier: Apache-2.0
// A projector at a V4L2 output: an HDMI output card, or the test driver vivid.
#pragma once
#include "capture/device/pattern_display.hpp"
#include "capture/v4l2/v4l2_format.hpp"

namespace fringetwin::capture {

struct V4l2DisplayOptions {
  std::string device;
  V4l2FormatWish format;  ///< width and height are the projector's
  unsigned buffers = 4;
};

/// A buffer comes back when the device has gone on to the next one: that is the time the next came on,
/// stamped by the driver where it stamps at all (`timed`).
class V4l2Display final : public PatternDisplay {
 public:
  /// Starts with a black picture. Throws UserError(device).
  explicit V4l2Display(V4l2DisplayOptions options, std::shared_ptr<V4l2Api> api = kernel_v4l2());

  DisplayInfo info() const override;
  Shown show(const Pattern& pattern, const ImageF& levels) override;

 private:
  void start();
  bool take_back(std::chrono::milliseconds timeout);
  bool queue_one(const ImageU16& dn);
  bool any_older(std::uint64_t picture) const;

  V4l2DisplayOptions options_;
  V4l2Device device_;
  V4l2Agreed agreed_;
  V4l2Buffers buffers_;
  std::vector<std::uint64_t> queued_;  ///< the picture in each buffer; 0: the buffer is ours
  std::uint64_t picture_ = 0;          ///< counts from 1
  Shown last_back_;
  bool broken_ = false;
};

}  // namespace fringetwin::capture
