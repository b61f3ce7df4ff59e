// SPDX-License-Identifier: Apache-2.0
// Puts a PNG of any colour type together from the bytes of its rows, without libpng.
#pragma once
#include <zlib.h>

#include <cstdint>
#include <string>

namespace fringetwin::testing {

inline std::string big_endian(std::uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
          static_cast<char>(v)};
}
inline std::string png_chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const auto crc = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return big_endian(static_cast<std::uint32_t>(data.size())) + body +
         big_endian(static_cast<std::uint32_t>(crc));
}
inline std::string packed(const std::string& text) {
  uLongf size = compressBound(text.size());
  std::string out(size, '\0');
  compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(text.data()),
            text.size(), 9);
  out.resize(size);
  return out;
}

struct PngHead {
  int width = 0, height = 0;
  int bits = 8;
  int color_type = 0;  ///< as PNG numbers them: 0 gray, 2 RGB, 3 palette, 4 gray and alpha, 6 RGB and alpha
};

/// Returns the file; `rows` without filter bytes, `more` chunks before the pixels.
inline std::string png_bytes(const PngHead& head, const std::string& rows, const std::string& more = "") {
  std::string filtered;
  const std::size_t row_bytes = rows.size() / static_cast<std::size_t>(head.height);
  for (std::size_t at = 0; row_bytes > 0 && at < rows.size(); at += row_bytes)
    filtered += std::string(1, '\0') + rows.substr(at, row_bytes);
  return "\x89PNG\r\n\x1a\n" +
         png_chunk("IHDR", big_endian(static_cast<std::uint32_t>(head.width)) +
                               big_endian(static_cast<std::uint32_t>(head.height)) +
                               std::string{static_cast<char>(head.bits), static_cast<char>(head.color_type),
                                           0, 0, 0}) +
         more + png_chunk("IDAT", packed(filtered)) + png_chunk("IEND", "");
}

}  // namespace fringetwin::testing
