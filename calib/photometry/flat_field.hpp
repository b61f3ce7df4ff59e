// SPDX-License-Identifier: Apache-2.0
// Estimates a camera's vignetting from an image of an evenly lit surface.
#pragma once
#include <array>
#include <optional>
#include <string>

#include "calib/photometry/photon_transfer.hpp"
#include "twin/image/image.hpp"
#include "twin/mosaic_channel.hpp"

namespace fringetwin::calib {

/// Where a pixel lies on the sensor, whose middle and corners [[camera]] vignetting counts from.
struct SensorPlaces {
  double middle_x = 0.0, middle_y = 0.0, half_width = 1.0, half_height = 1.0;  ///< px of the image

  /// Of an image of the whole sensor, or of the pixels of one colour of it.
  SensorPlaces(int width, int height, const std::optional<MosaicChannel>& channel);
  double x(double x_px) const { return (x_px - middle_x) / half_width; }
  double y(double y_px) const { return (y_px - middle_y) / half_height; }
  /// Returns r^2, 1 at the corners.
  double s(double x_px, double y_px) const;
};

/// value = level (1 + gx X + gy Y)(1 + a1 s + a2 s^2 + a3 s^3) over the cell means of a grid: X, Y in half
/// widths from the image's middle (light that is uneven from one side to the other is no vignetting), s = r^2
/// with r = 1 at the corners, as [[camera]] vignetting.
struct FlatField {
  Estimate level_dn, gradient_x, gradient_y;
  std::array<Estimate, 3> a{};                ///< terms left out are 0 +- 0
  int terms = 0;                              ///< 1...3: the fewest that describe the image
  double corner = 1.0;                        ///< 1 + a1 + a2 + a3
  double residual_rms = 0.0;                  ///< of the cells, relative to the level
  std::size_t n = 0;                          ///< cells
  std::optional<MosaicChannel> channel = {};  ///< of the sensor, which X, Y and r are of
};

/// `flat` less the black level. Cells with a saturated pixel are left out. Throws UserError(input).
FlatField fit_flat_field(const ImageF& flat, double black_level_dn, double saturation_dn,
                         const std::string& where, const std::optional<MosaicChannel>& channel = {});

/// Returns the light that the field gives each pixel.
ImageD light_of(const FlatField& field, int width, int height);

}  // namespace fringetwin::calib
