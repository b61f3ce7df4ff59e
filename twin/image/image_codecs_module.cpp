// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <exception>
#include <optional>

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
  *image = {.width = width, .height = height, .channels = 1, .bits = bits, .values = {}};
  image->values.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                       static_cast<std::size_t>(bits / 8));
}

/// Returns the place of a colour among the bytes of a BMP's pixel or palette: blue comes first.
std::size_t place_in_bmp(ColourChannel channel) { return 2 - static_cast<std::size_t>(channel); }

/// Turns the rows' palette numbers into gray values; a colour in it makes a colour image, unless one of the
/// colours is wanted.
bool look_up(const PlainBytes& bytes, std::size_t palette, std::size_t entry_bytes, std::size_t n,
             const ColourChannel* wanted, DecodedImage* image) {
  std::array<std::uint8_t, 256> gray{};
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t at = palette + k * entry_bytes;
    gray[k] = static_cast<std::uint8_t>(
        bytes.little_endian(at + (wanted != nullptr ? place_in_bmp(*wanted) : 0), 1));
    if (wanted == nullptr &&
        (bytes.little_endian(at + 1, 1) != gray[k] || bytes.little_endian(at + 2, 1) != gray[k]))
      image->channels = 3;
  }
  for (std::uint8_t& value : image->values) {
    if (value >= n) return false;
    value = gray[value];
  }
  return true;
}

/// Takes the byte at `place` of each pixel; rows are filled up to 4 bytes.
bool take_rows(PlainBytes& bytes, bool top_first, std::size_t pixel_bytes, std::size_t place,
               DecodedImage* image) {
  const auto width = static_cast<std::size_t>(image->width), height = static_cast<std::size_t>(image->height);
  const std::size_t used = width * pixel_bytes, stored = (used + 3) / 4 * 4;
  for (std::size_t k = 0; k < height; ++k) {
    const std::uint8_t* values = bytes.take(k + 1 == height ? used : stored);
    if (values == nullptr) return false;
    std::uint8_t* row = &image->values[width * (top_first ? k : height - 1 - k)];
    for (std::size_t x = 0; x < width; ++x) row[x] = values[x * pixel_bytes + place];
  }
  return true;
}

/// Returns which byte of a pixel of 24 or 32 bits holds the colour; nothing where the colours are no bytes of
/// their own.
std::optional<std::size_t> byte_of_colour(const PlainBytes& bytes, std::int64_t compression,
                                          std::int64_t bits, ColourChannel channel) {
  if (compression == 0 && (bits == 24 || bits == 32)) return place_in_bmp(channel);
  if (compression != 3 || bits != 32) return {};  // 3: a mask for each colour, red first
  const auto mask =
      static_cast<std::uint32_t>(bytes.little_endian(54 + 4 * static_cast<std::size_t>(channel), 4));
  for (std::size_t k = 0; k < 4; ++k)
    if (mask == 0xffU << (8 * k)) return k;
  return {};
}

/// 8 bits a pixel through a palette, or a colour of 24 or 32 bits, uncompressed; rows begin with the lowest.
bool decode_bmp(PlainBytes bytes, const ColourChannel* wanted, DecodedImage* image) {
  const auto info_bytes = static_cast<std::size_t>(bytes.little_endian(14, 4));
  const bool old = info_bytes == 12;
  const int width = static_cast<int>(bytes.little_endian(18, old ? 2 : 4));
  const int height = static_cast<int>(bytes.little_endian(old ? 20 : 22, old ? 2 : 4));
  const std::int64_t bits = bytes.little_endian(old ? 24 : 28, 2);
  if (width <= 0 || height == 0 || height == INT32_MIN) return false;
  *image = {.width = width,
            .height = height < 0 ? -height : height,
            .channels = bits > 8 ? static_cast<int>(bits / 8) : 1,
            .bits = 0,
            .values = {}};
  const std::int64_t compression = old ? 0 : bytes.little_endian(30, 4);
  bytes.go_to(static_cast<std::size_t>(bytes.little_endian(10, 4)) & 0xffffffffU);
  if (bits > 8 && wanted != nullptr) {
    const auto place = byte_of_colour(bytes, compression, bits, *wanted);
    if (!place) {
      image->fault =
          "is a BMP whose colours are no bytes of their own; save it with 24 bits a pixel, or as PNG";
      return true;
    }
    begin_gray(width, image->height, 8, image);
    return take_rows(bytes, height < 0, static_cast<std::size_t>(bits) / 8, *place, image);
  }
  if (bits != 8) return true;
  if (compression != 0) return false;  // run lengths
  const std::int64_t named = old ? 0 : bytes.little_endian(46, 4);
  const std::size_t colours = named > 0 && named < 256 ? static_cast<std::size_t>(named) : 256;
  begin_gray(width, image->height, 8, image);
  if (!take_rows(bytes, height < 0, 1, 0, image)) return false;
  return look_up(bytes, 14 + info_bytes, old ? 3 : 4, colours, wanted, image);
}

/// P5 and P6: values of 1 or 2 bytes, the high one first; of P6 the colour alone.
bool take_binary(PlainBytes& bytes, const ColourChannel* colour, DecodedImage* image) {
  bytes.next();  // one blank behind the largest value
  const std::uint8_t* values = bytes.take(image->values.size() * (colour != nullptr ? 3 : 1));
  if (values == nullptr) return false;
  if (colour == nullptr) {
    std::memcpy(image->values.data(), values, image->values.size());
  } else {
    const std::size_t n = static_cast<std::size_t>(image->bits) / 8;
    values += n * static_cast<std::size_t>(*colour);
    for (std::size_t k = 0; k < image->values.size(); k += n)
      for (std::size_t byte = 0; byte < n; ++byte) image->values[k + byte] = values[3 * k + byte];
  }
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

bool decode_pnm(PlainBytes bytes, const ColourChannel* wanted, DecodedImage* image) {
  bytes.next();
  const int kind = bytes.next();
  const int width = bytes.decimal(), height = bytes.decimal(), most = bytes.decimal();
  if (width <= 0 || height <= 0) return false;
  const bool colour = kind == '3' || kind == '6';
  *image = {.width = width, .height = height, .channels = colour ? 3 : 1, .bits = 0, .values = {}};
  if (kind == '3' && wanted != nullptr)
    image->fault = "is a colour image as decimal text (P3); save it as binary PPM (P6), or as PNG";
  if (kind != '2' && kind != '5' && (kind != '6' || wanted == nullptr)) return true;
  if (most <= 0 || most > 65535) return false;
  begin_gray(width, height, most > 255 ? 16 : 8, image);
  return kind == '2' ? take_decimal(bytes, most, image)
                     : take_binary(bytes, colour ? wanted : nullptr, image);
}

}  // namespace
}  // namespace fringetwin

extern "C" bool fringetwin_decode_image_2(const std::uint8_t* bytes, std::size_t size,
                                          const fringetwin::ColourChannel* wanted,
                                          fringetwin::DecodedImage* image) {
  try {
    if (size < 4) return false;
    if (bytes[0] == 'B') return fringetwin::decode_bmp({bytes, size}, wanted, image);
    if (bytes[0] == 'P') return fringetwin::decode_pnm({bytes, size}, wanted, image);
    return fringetwin::decode_tiff(bytes, size, wanted, image);
  } catch (const std::exception&) {  // no memory
    return false;
  }
}
