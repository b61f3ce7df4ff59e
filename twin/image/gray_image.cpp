// SPDX-License-Identifier: Apache-2.0
#include "twin/image/gray_image.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "twin/base/errors.hpp"

namespace fringetwin {
namespace {

// Returns whether all values are whole numbers that T holds. A value outside would be undefined behaviour to
// convert: it is clamped first, NaN to 0.
template <class T>
bool all_fit(const std::vector<float>& values) {
  constexpr std::size_t kAtATime = 4096;  // without a branch for each value
  constexpr auto most = static_cast<float>(std::numeric_limits<T>::max());
  for (std::size_t first = 0; first < values.size(); first += kAtATime) {
    const std::size_t end = std::min(values.size(), first + kAtATime);
    unsigned differ = 0;
    for (std::size_t i = first; i < end; ++i) {
      const float inside = values[i] > 0.0F ? std::min(values[i], most) : 0.0F;
      differ |= static_cast<unsigned>(static_cast<float>(static_cast<std::int32_t>(inside)) != values[i]);
    }
    if (differ != 0) return false;
  }
  return true;
}

template <class T>
std::vector<T> converted(const std::vector<float>& values) {
  std::vector<T> out(values.size());
  std::ranges::transform(values, out.begin(),
                         [](float v) { return static_cast<T>(static_cast<std::int32_t>(v)); });
  return out;
}

}  // namespace

GrayImage GrayImage::packed(ImageF values) {
  GrayImage image(std::move(values));
  if (all_fit<std::uint8_t>(image.floats_)) {
    image.bytes_ = converted<std::uint8_t>(image.floats_);
    image.kept_as_ = KeptAs::bytes;
  } else if (all_fit<std::uint16_t>(image.floats_)) {
    image.words_ = converted<std::uint16_t>(image.floats_);
    image.kept_as_ = KeptAs::words;
  } else {
    return image;
  }
  std::vector<float>().swap(image.floats_);
  return image;
}

GrayImage GrayImage::sum(ImageSum sum, int width, int height) {
  GrayImage image;
  image.width = width;
  image.height = height;
  image.sum_ = std::make_shared<const ImageSum>(std::move(sum));
  image.kept_as_ = KeptAs::sum;
  return image;
}

std::span<const float> GrayImage::values(std::size_t first, std::size_t n, std::vector<float>& room) const {
  FT_CHECK(first <= size() && n <= size() - first, "values of the image");
  if (kept_as_ == KeptAs::floats) return {floats_.data() + first, n};
  if (room.size() < n) room.resize(n);
  const auto convert = [&](const auto* from) {
    std::transform(from, from + n, room.begin(), [](auto v) { return static_cast<float>(v); });
  };
  if (kept_as_ == KeptAs::sum)
    sum_->compute(first, n, room.data());
  else
    kept_as_ == KeptAs::bytes ? convert(bytes_.data() + first) : convert(words_.data() + first);
  return {room.data(), n};
}

ImageF GrayImage::floats() const {
  ImageF out(width, height);
  if (sum_) {
    sum_->compute(0, out.size(), out.data.data());
    return out;
  }
  std::size_t i = 0;
  for_each([&](float value) { out.data[i++] = value; });
  return out;
}

std::vector<float>& GrayImage::as_floats() {
  if (kept_as_ == KeptAs::floats) return floats_;  // several threads may write at a time
  floats_ = floats().data;
  std::vector<std::uint8_t>().swap(bytes_);
  std::vector<std::uint16_t>().swap(words_);
  sum_.reset();
  kept_as_ = KeptAs::floats;
  return floats_;
}

}  // namespace fringetwin
