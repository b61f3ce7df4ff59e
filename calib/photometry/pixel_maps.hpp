// SPDX-License-Identifier: Apache-2.0
// Estimates what each pixel of a sensor has of its own from repeated images: its offset from dark ones
// (DSNU), the factor of its gain from evenly lit ones (PRNU).
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/photometry/flat_field.hpp"
#include "twin/camera_response.hpp"
#include "twin/image/gray_image.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::calib {

/// A number for each pixel, and how well it is known.
struct PixelMapEstimate {
  ImageF map;
  double rms = 0.0;           ///< by how much the pixels differ, without the noise of the means
  double noise = 0.0;         ///< standard error of each pixel: the noise of the means
  std::size_t n_images = 0;   ///< that were averaged
  std::size_t n_unknown = 0;  ///< pixels that are clipped, or without light: their factor is 1
  /// Returns whether the map is more pattern than noise: another one would do harm.
  bool is_told() const { return rms > noise; }
};

/// Returns the offsets of the pixels, DN, mean 0. Nothing with fewer than two images.
std::optional<PixelMapEstimate> pixel_offsets(const std::vector<GrayImage>& dark);

/// What a gray value of the flat images has besides the factor of its pixel.
struct FlatLight {
  double black_level_dn = 0.0, saturation_dn = 255.0;
  const CameraResponse& response;
  const PixelMapEstimate* offsets = nullptr;  ///< null: none known
  const FlatField& field;                     ///< what light and lens do over the image
};
/// Returns the factors of the pixels, mean 1, over the light around each: the fitted field, and of what it
/// leaves the mean over 31 x 31 pixels. Nothing with fewer than two images, or where no pixel is usable.
std::optional<PixelMapEstimate> pixel_factors(const std::vector<GrayImage>& flat, const FlatLight& light);

/// Returns the name of the file that holds a map: "prnu_left.exr".
std::string pixel_map_file(const std::string& key, const std::string& camera);

}  // namespace fringetwin::calib
