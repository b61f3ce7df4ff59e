// SPDX-License-Identifier: Apache-2.0
// Tells how far each part of a frame is on its way from the projector's black to its white.
#pragma once
#include <string>
#include <vector>

#include "capture/device/camera_device.hpp"

namespace fringetwin::capture {

/// The image is looked at in 4 x 4 parts: a display that tears, or a shutter that rolls, changes them one
/// after the other. The level of a part is the sum of its pixels weighted with their own difference W - B,
/// the best weights against noise; levels of black and white, known from several frames, make it a share:
/// light and gain cancel.
class LightLevels {
 public:
  /// Throws UserError(device) naming the camera: white not brighter than black anywhere, all that is lit
  /// saturated, or light that scatters from frame to frame so much that no change can be told from it.
  LightLevels(const std::string& camera, const std::vector<ImageU16>& black,
              const std::vector<ImageU16>& white, int bit_depth);

  /// Returns the share of each part in use: 0 = black, 1 = white.
  std::vector<double> shares(const ImageU16& frame) const;
  /// Returns the least difference of two shares that counts: 8 times their scatter over the frames given
  /// (scatter itself known from some 14 values only, thousands of shares looked at), at least 0.02.
  double threshold() const { return threshold_; }
  double black_dn() const { return black_dn_; }  ///< mean of the pixels in use
  double white_dn() const { return white_dn_; }

 private:
  struct Pixel {
    std::uint32_t index = 0;
    float weight = 0.0f;
  };
  struct Part {
    std::vector<Pixel> pixels;
    double black = 0.0, range = 0.0;
  };
  void choose_pixels(const std::string& camera, const std::vector<ImageU16>& black,
                     const std::vector<ImageU16>& white, int bit_depth);
  void set_mean_levels(const std::vector<double>& black, const std::vector<double>& white);
  static double raw_level(const Part& part, const ImageU16& frame);
  std::vector<std::vector<double>> raw_levels(const std::vector<ImageU16>& frames) const;

  std::vector<Part> parts_;
  double threshold_ = 0.0, black_dn_ = 0.0, white_dn_ = 0.0;
};

}  // namespace fringetwin::capture
