// SPDX-License-Identifier: Apache-2.0
// Decodes PNG to gray values and encodes grayscale PNG in memory, through libpng. Thread-safe: no shared
// state.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "twin/image/colour_channel.hpp"

namespace fringetwin {

/// Pixels of one gray image: row-major, one value each, native byte order.
struct GrayPixels {
  int width = 0;
  int height = 0;
  int file_bits = 8;                 ///< 8 (also for 1, 2, 4 bit files) or 16
  std::vector<std::uint8_t> values;  ///< 1 or 2 bytes a pixel
};

/// Returns whether `bytes` start with the PNG signature.
bool is_png(const std::vector<std::uint8_t>& bytes);

/// What to do about a colour image of which no colour is named.
constexpr const char* kNameAColour =
    "one colour of it is taken where a capture set says channel = \"green\" in capture.toml "
    "(import captures and photometry: --channel green)";

/// Decodes a PNG. Stored values are not scaled (a 1-bit file gives 0 and 1); gamma chunks are ignored. Of a
/// colour image the values of `channel` are taken, without regard to its alpha.
/// Returns an empty string, or what is wrong with the file ("is a colour image (RGB)", "is truncated ...").
std::string decode_gray_png(const std::vector<std::uint8_t>& bytes,
                            const std::optional<ColourChannel>& channel, GrayPixels* pixels);

/// Encodes with fast compression. `values`: 1 byte a pixel for 8 bit, 2 (native order) for 16 bit.
/// Returns an empty string or libpng's complaint.
std::string encode_gray_png(const GrayPixels& pixels, std::vector<std::uint8_t>* bytes);

}  // namespace fringetwin
