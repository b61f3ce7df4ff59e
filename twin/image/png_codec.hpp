// SPDX-License-Identifier: Apache-2.0
// Decodes and encodes grayscale PNG in memory, through libpng. Thread-safe: no shared state.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace fringetwin {

/// Pixels of one grayscale PNG: row-major, one value each, native byte order.
struct GrayPixels {
  int width = 0;
  int height = 0;
  int file_bits = 8;                 ///< 8 (also for 1, 2, 4 bit files) or 16
  std::vector<std::uint8_t> values;  ///< 1 or 2 bytes a pixel
};

/// Returns whether `bytes` start with the PNG signature.
bool is_png(const std::vector<std::uint8_t>& bytes);

/// Decodes a PNG. Stored values are not scaled (a 1-bit file gives 0 and 1); gamma chunks are ignored.
/// Returns an empty string, or what is wrong with the file ("is a colour image (RGB)", "is truncated ...").
std::string decode_gray_png(const std::vector<std::uint8_t>& bytes, GrayPixels* pixels);

/// Encodes with fast compression. `values`: 1 byte a pixel for 8 bit, 2 (native order) for 16 bit.
/// Returns an empty string or libpng's complaint.
std::string encode_gray_png(const GrayPixels& pixels, std::vector<std::uint8_t>* bytes);

}  // namespace fringetwin
