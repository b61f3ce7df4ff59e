// SPDX-License-Identifier: Apache-2.0
// Holds the gray values of an image in as few bytes as they need: a camera's are whole numbers of 8 or 16
// bits, and a sequence of them is what a run holds most of. The light before a sensor may be a sum of images
// that others are sums of, too.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "twin/image/image.hpp"
#include "twin/image/image_sum.hpp"

namespace fringetwin {

class GrayImage {
 public:
  GrayImage() = default;
  /// Takes the values as floats; implicit, since nothing of them is lost, but never a copy of an image.
  GrayImage(ImageF&& values) : width(values.width), height(values.height), floats_(std::move(values.data)) {}
  /// Keeps values that are whole numbers from 0 to 65535 in one byte each, or in two where one is above 255,
  /// and others as floats: reading gives the same values.
  static GrayImage packed(ImageF values);
  /// Keeps no value but what they are the sum of; reading computes them.
  static GrayImage sum(ImageSum sum, int width, int height);

  int width = 0, height = 0;  ///< px

  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  bool empty() const { return size() == 0; }
  template <class Other>
  bool same_size(const Other& other) const {
    return width == other.width && height == other.height;
  }
  float operator[](std::size_t i) const {
    return kept_as_ == KeptAs::bytes    ? static_cast<float>(bytes_[i])
           : kept_as_ == KeptAs::floats ? floats_[i]
           : kept_as_ == KeptAs::sum    ? (*sum_)[i]
                                        : static_cast<float>(words_[i]);
  }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  float operator()(int x, int y) const { return (*this)[index(x, y)]; }
  /// Returns n values from `first` on; they stand in `room` where they are not kept as floats, which makes
  /// them valid until it changes.
  std::span<const float> values(std::size_t first, std::size_t n, std::vector<float>& room) const;
  /// Returns all values.
  ImageF floats() const;
  /// Calls use(value) with every value in their order.
  template <class Use>
  void for_each(const Use& use) const {
    for (const std::uint8_t v : bytes_) use(static_cast<float>(v));
    for (const std::uint16_t v : words_) use(static_cast<float>(v));
    for (const float v : floats_) use(v);
    if (sum_)
      for (std::size_t i = 0; i < size(); ++i) use((*sum_)[i]);
  }
  /// Keeps the values as floats from now on and returns them, to be written. Several threads may call it at a
  /// time where they are floats already; else nobody else may read the image meanwhile.
  std::vector<float>& as_floats();
  /// Returns the value of one pixel, to be written, as as_floats() does.
  float& writable(int x, int y) { return as_floats()[index(x, y)]; }
  /// Returns how many bytes the values take; none of a sum, whose images are its owner's.
  std::size_t bytes() const { return bytes_.size() + 2 * words_.size() + sizeof(float) * floats_.size(); }

 private:
  enum class KeptAs : std::uint8_t { floats, bytes, words, sum };
  KeptAs kept_as_ = KeptAs::floats;
  std::vector<std::uint8_t> bytes_;  ///< one of the four holds the values, the others are empty
  std::vector<std::uint16_t> words_;
  std::vector<float> floats_;
  std::shared_ptr<const ImageSum> sum_;
};

}  // namespace fringetwin
