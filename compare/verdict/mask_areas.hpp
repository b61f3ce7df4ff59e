// SPDX-License-Identifier: Apache-2.0
// Widens, narrows and smooths areas of a mask (0 or 1 per pixel), and finds their edges and their
// connected areas. Neighbours are the eight around a pixel.
#pragma once
#include <cstddef>
#include <vector>

#include "twin/image/image.hpp"

namespace fringetwin::compare {

/// Returns 1 where a pixel of the mask is at most this many pixels away along both axes.
ImageU8 dilated(const ImageU8& mask, int radius_px);
/// Returns 1 where every pixel at most this far away along both axes is set. Pixels outside the image count
/// as set, so that the edge of the image wears nothing away.
ImageU8 eroded(const ImageU8& mask, int radius_px);
/// Returns the mask with gaps narrower than twice the radius filled, so that single pixels missing here and
/// there make no outline.
ImageU8 closed(const ImageU8& mask, int radius_px);
/// Returns the pixels on both sides of the mask's outline, one on each. The edge of the image is none.
ImageU8 edge(const ImageU8& mask);
/// Returns 1 where either mask is set.
ImageU8 either(const ImageU8& a, const ImageU8& b);
/// Returns the mask with 0 where the other one is set.
ImageU8 without(ImageU8 mask, const ImageU8& other);

/// Returns the indices of the pixels of each connected area of the mask, in the order of their first pixels.
std::vector<std::vector<std::size_t>> all_areas(const ImageU8& mask);
/// Returns the indices of the pixels of the mask's largest connected area; empty for an empty mask.
std::vector<std::size_t> largest_area(const ImageU8& mask);

}  // namespace fringetwin::compare
