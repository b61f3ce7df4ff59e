// SPDX-License-Identifier: Apache-2.0
// Applies to an image what each pixel has of its own, and what a texture that changes within a pixel does to
// the fringes (docs/PHYSICS.md, "Camera lens").
#pragma once
#include <cstddef>

#include "twin/image/gray_image.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::render {

/// Returns the slope of an image (ImageF, GrayImage) at a pixel along an axis, on which neighbours lie
/// `distance` apart in the data: by two on either side, exact for polynomials of order 4, or by one (not
/// `is_wide`).
template <class AnyImage>
double slope_along(const AnyImage& image, std::size_t i, std::size_t distance, bool is_wide = true);

/// Returns by how much a pixel's irradiance exceeds factor * image where both change within it, over
/// spread_px^2: the sum over both axes of the products of their slopes, by the five pixels around it, or
/// three where the outer ones lie beyond the border, are dark or have no factor; 0 where the inner ones are
/// so.
template <class AnyImage>
double texture_moment(const ImageF& factor, const AnyImage& image, int x, int y);

/// Makes of every value e: factor * e + spread_px^2 * texture_moment() + exposure * offset, not below 0 by
/// the middle term. `exposure`: factor of the image, which e has already. `spread_px` 0: the line of each
/// pixel.
void apply_pixel_texture(const PixelTexture& texture, double spread_px, double exposure, ImageF& image);

}  // namespace fringetwin::render
