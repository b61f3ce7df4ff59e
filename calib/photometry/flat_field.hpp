// SPDX-License-Identifier: Apache-2.0
// Estimates a camera's vignetting from an image of an evenly lit surface.
#pragma once
#include <array>
#include <string>

#include "calib/photometry/photon_transfer.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::calib {

/// value = level (1 + gx X + gy Y)(1 + a1 s + a2 s^2 + a3 s^3) over the cell means of a grid: X, Y in half
/// widths from the image's middle (light that is uneven from one side to the other is no vignetting), s = r^2
/// with r = 1 at the corners, as [[camera]] vignetting.
struct FlatField {
  Estimate level_dn, gradient_x, gradient_y;
  std::array<Estimate, 3> a{};  ///< terms left out are 0 +- 0
  int terms = 0;                ///< 1...3: the fewest that describe the image
  double corner = 1.0;          ///< 1 + a1 + a2 + a3
  double residual_rms = 0.0;    ///< of the cells, relative to the level
  std::size_t n = 0;            ///< cells
};

/// `flat` less the black level. Cells with a saturated pixel are left out. Throws UserError(input).
FlatField fit_flat_field(const ImageF& flat, double black_level_dn, double saturation_dn,
                         const std::string& where);

}  // namespace fringetwin::calib
