// SPDX-License-Identifier: Apache-2.0
// Reads the same pixels of several images as floats, whatever the images keep them as.
#pragma once
#include <cstddef>
#include <deque>
#include <vector>

#include "twin/image/gray_image.hpp"

namespace fringetwin {

/// For loops over rows: start() with each row, next() with each image of it. One for each thread.
class RowsOfImages {
 public:
  void start() { used_ = 0; }
  /// Returns n values of the image from `first` on; valid until start().
  const float* next(const GrayImage& image, std::size_t first, std::size_t n) {
    if (used_ == rooms_.size()) rooms_.emplace_back();
    return image.values(first, n, rooms_[used_++]).data();
  }
  /// Returns all values of the image; valid until start().
  const float* whole(const GrayImage& image) { return next(image, 0, image.size()); }

 private:
  std::deque<std::vector<float>> rooms_;  ///< a deque's elements stay where they are
  std::size_t used_ = 0;
};

}  // namespace fringetwin
