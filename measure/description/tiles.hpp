// SPDX-License-Identifier: Apache-2.0
// Cuts a few tiles out of a camera's images, side by side in small images that decode in milliseconds.
#pragma once
#include <vector>

#include "twin/captures/capture_set.hpp"

namespace fringetwin::measure {

/// Which tiles of a camera's images are looked at: those with the most pixels that the fringes reach.
class Tiles {
 public:
  /// `min_modulation_dn`: half of the range of a pixel's gray values from which it counts as reached; a
  /// saturated pixel does not count.
  Tiles(const CameraImages& images, double min_modulation_dn);

  bool empty() const { return corners_.empty(); }
  std::size_t size() const { return corners_.size(); }
  /// Returns one of them alone.
  Tiles only(std::size_t k) const;
  /// Returns the tiles of all images, white and black ones included. Between the tiles stands `gap`.
  CameraImages cut(const CameraImages& images) const;
  /// Returns the tiles of one image; `gap` between them.
  ImageF cut(const ImageF& image, float gap) const;
  ImageD cut(const ImageD& image, double gap) const;

 private:
  Tiles() = default;
  template <class T, class AnyImage>
  Image<T> cut_from(const AnyImage& image, T gap) const;
  struct Corner {
    int x = 0, y = 0;
  };
  std::vector<Corner> corners_;
};

/// Returns 1 for every pixel of `images` that the fringes reach: its gray values range over twice
/// `min_modulation_dn` or more and none is saturated; else 0.
ImageU8 reached_pixels(const CameraImages& images, double min_modulation_dn);

}  // namespace fringetwin::measure
