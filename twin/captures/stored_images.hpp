// SPDX-License-Identifier: Apache-2.0
// The images of a capture set as they are stored, where no twin says what they are.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "twin/captures/capture_set.hpp"

namespace fringetwin {

/// One camera's images. What only a twin knows is not in them: their number, the bits of the sensor, which
/// pixels are of a channel, where values stop.
struct StoredImages {
  std::string camera = {};
  std::vector<GrayImage> images = {};
  std::optional<GrayImage> white = {}, black = {};
  int file_bits = 8;      ///< of values in the files: 8, 16; 32 for EXR
  bool radiance = false;  ///< EXR: irradiance, before a sensor
};

/// Loads the images of all cameras of a set that was read without a number of images; all of a camera must
/// have the size of its first one. Throws UserError(input) naming the image, as read_gray() and
/// read_irradiance() do.
std::vector<StoredImages> load_stored_images(const CaptureSet& set);

}  // namespace fringetwin
