// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <exception>

#include "twin/image/image_codecs.hpp"

namespace fringetwin {
namespace {

/// The bytes of a file, taken one after the other; what lies behind the end is -1.
class PlainBytes {
 public:
  PlainBytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  int next() { return at_ < size_ ? data_[at_++] : -1; }
  int peek() const { return at_ < size_ ? data_[at_] : -1; }
  void go_to(std::size_t at) { at_ = at; }
  /// Returns `n` bytes, or nullptr where there are fewer.
  const std::uint8_t* take(std::size_t n) {
    if (at_ > size_ || n > size_ - at_) return nullptr;
    at_ += n;
    return data_ + at_ - n;
  }
  std::int64_t little_endian(std::size_t at, int n) const {
    std::uint32_t value = 0;
    for (int k = 0; k < n && at + k < size_; ++k)
      value |= static_cast<std::uint32_t>(data_[at + k]) << (8 * k);
    return static_cast<std::int32_t>(value);
  }
  /// Returns the next decimal number of a PNM, at most 9 digits; -1 where there is none.
  int decimal() {
    while (peek() == '#' || std::isspace(peek()) != 0) {
      const bool comment = next() == '#';
      while (comment && peek() >= 0 && peek() != '\n' && peek() != '\r') next();
    }
    int value = -1;
    for (int digits = 0; digits < 9 && std::isdigit(peek()) != 0; ++digits)
      value = 10 * (value < 0 ? 0 : value) + (next() - '0');
    return std::isdigit(peek()) != 0 ? -1 : value;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

void begin_gray(int width, int height, int bits, DecodedImage* image) {
  *image = {width, height, 1, bits, {}};
  image->values.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                       static_cast<std::size_t>(bits / 8));
}

/// Turns the rows' palette numbers into gray values; a colour in it makes a colour image.
bool look_up(const PlainBytes& bytes, std::size_t palette, std::size_t entry_bytes, std::size_t n,
             DecodedImage* image) {
  std::array<std::uint8_t, 256> gray{};
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t at = palette + k * entry_bytes;
    gray[k] = static_cast<std::uint8_t>(bytes.little_endian(at, 1));
    if (bytes.little_endian(at + 1, 1) != gray[k] || bytes.little_endian(at + 2, 1) != gray[k])
      image->channels = 3;
  }
  for (std::uint8_t& value : image->values) {
    if (value >= n) return false;
    value = gray[value];
  }
  return true;
}

/// 8 bits a pixel through a palette, uncompressed; rows are filled up to 4 bytes and begin with the lowest.
bool decode_bmp(PlainBytes bytes, DecodedImage* image) {
  const auto info_bytes = static_cast<std::size_t>(bytes.little_endian(14, 4));
  const bool old = info_bytes == 12;
  const int width = static_cast<int>(bytes.little_endian(18, old ? 2 : 4));
  const int height = static_cast<int>(bytes.little_endian(old ? 20 : 22, old ? 2 : 4));
  const std::int64_t bits = bytes.little_endian(old ? 24 : 28, 2);
  if (width <= 0 || height == 0 || height == INT32_MIN) return false;
  *image = {width, height < 0 ? -height : height, bits > 8 ? static_cast<int>(bits / 8) : 1, 0, {}};
  if (bits != 8) return true;
  if (!old && bytes.little_endian(30, 4) != 0) return false;  // run lengths
  const std::int64_t named = old ? 0 : bytes.little_endian(46, 4);
  const std::size_t colours = named > 0 && named < 256 ? static_cast<std::size_t>(named) : 256;
  begin_gray(width, image->height, 8, image);
  bytes.go_to(static_cast<std::size_t>(bytes.little_endian(10, 4)) & 0xffffffffU);
  const auto row = static_cast<std::size_t>(width), stored = (row + 3) / 4 * 4;
  for (int k = 0; k < image->height; ++k) {
    const bool last = k + 1 == image->height;
    const std::uint8_t* values = bytes.take(last ? row : stored);
    if (values == nullptr) return false;
    std::memcpy(&image->values[row * static_cast<std::size_t>(height < 0 ? k : height - 1 - k)], values, row);
  }
  return look_up(bytes, 14 + info_bytes, old ? 3 : 4, colours, image);
}

/// P5: values of 1 or 2 bytes, the high one first.
bool take_binary(PlainBytes& bytes, DecodedImage* image) {
  bytes.next();  // one blank behind the largest value
  const std::uint8_t* values = bytes.take(image->values.size());
  if (values == nullptr) return false;
  std::memcpy(image->values.data(), values, image->values.size());
  if (image->bits == 16 && std::endian::native == std::endian::little)
    for (std::size_t k = 0; k < image->values.size(); k += 2)
      std::swap(image->values[k], image->values[k + 1]);
  return true;
}

/// P2: decimal numbers.
bool take_decimal(PlainBytes& bytes, int most, DecodedImage* image) {
  const std::size_t n = static_cast<std::size_t>(image->bits) / 8;
  for (std::size_t k = 0; k < image->values.size(); k += n) {
    const int value = bytes.decimal();
    if (value < 0 || value > most) return false;
    const auto byte = static_cast<std::uint8_t>(value);
    const auto wide = static_cast<std::uint16_t>(value);
    std::memcpy(&image->values[k], n == 1 ? static_cast<const void*>(&byte) : &wide, n);
  }
  return true;
}

bool decode_pnm(PlainBytes bytes, DecodedImage* image) {
  bytes.next();
  const int kind = bytes.next();
  const int width = bytes.decimal(), height = bytes.decimal(), most = bytes.decimal();
  if (width <= 0 || height <= 0) return false;
  *image = {width, height, kind == '3' || kind == '6' ? 3 : 1, 0, {}};
  if (kind != '2' && kind != '5') return true;
  if (most <= 0 || most > 65535) return false;
  begin_gray(width, height, most > 255 ? 16 : 8, image);
  return kind == '5' ? take_binary(bytes, image) : take_decimal(bytes, most, image);
}

}  // namespace
}  // namespace fringetwin

extern "C" bool fringetwin_decode_image_1(const std::uint8_t* bytes, std::size_t size,
                                          fringetwin::DecodedImage* image) {
  try {
    if (size < 4) return false;
    if (bytes[0] == 'B') return fringetwin::decode_bmp({bytes, size}, image);
    if (bytes[0] == 'P') return fringetwin::decode_pnm({bytes, size}, image);
    return fringetwin::decode_tiff(bytes, size, image);
  } catch (const std::exception&) {  // no memory
    return false;
  }
}
