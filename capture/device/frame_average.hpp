// SPDX-License-Identifier: Apache-2.0
// Averages the frames of one pattern into the gray values of an image file.
#pragma once
#include <cstdint>
#include <vector>

#include "capture/device/camera_device.hpp"

namespace fringetwin::capture {

/// Sum of frames. A pixel that reached the clip in any of them stays saturated: its mean would be too low.
class FrameAverage {
 public:
  /// Frames of `camera_bits` become gray values of `stored_bits`, the twin's bit_depth.
  FrameAverage(int camera_bits, int stored_bits);
  /// Throws UserError(device) for a value above stored_bits where the camera's words are wider (`device`
  /// names it).
  void add(ImageU16 dn, const std::string& device);
  int count() const { return count_; }

  /// The mean, rounded by the PNG. Where the file is deeper than the camera, full scale maps to full scale:
  /// mean (2^stored - 1)/(2^camera - 1).
  ImageF stored() const;

 private:
  void refuse_above_clip(const ImageU16& dn, const std::string& device) const;

  int camera_bits_, stored_bits_;
  std::uint16_t clip_dn_;
  int count_ = 0;
  ImageU16 first_;  ///< alone, most images have no other
  std::vector<std::uint32_t> sum_;
  std::vector<std::uint8_t> clipped_;
};

/// Throws UserError(usage): a file deeper than the camera holds noise-free digits only where frames are
/// averaged or exposures merged.
void check_depths(const std::string& camera, int camera_bits, int stored_bits, bool several_frames);

}  // namespace fringetwin::capture
