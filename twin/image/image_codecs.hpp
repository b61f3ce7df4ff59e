// SPDX-License-Identifier: Apache-2.0
// Decodes gray BMP, TIFF and PGM, in a module of its own that is loaded when such a file is met: libtiff
// brings a dozen shared libraries that every start of the program would pay for.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fringetwin {

struct DecodedImage {
  int width = 0, height = 0, channels = 0;
  int bits = 0;  ///< 8 or 16, unsigned; 0: another kind of number
  std::vector<std::uint8_t>
      values;  ///< rows without gaps, native byte order; empty unless gray with 8 or 16 bits
};

/// The module's only function, by this name. Takes the bytes of a whole file whose header
/// read_image_header() has taken; returns false where it cannot be decoded to its last pixel.
using DecodeImageFunction = bool (*)(const std::uint8_t* bytes, std::size_t size, DecodedImage* image);
constexpr const char* kDecodeImageName = "fringetwin_decode_image_1";  ///< 1: DecodedImage as it stands here

/// What the module does for a TIFF.
bool decode_tiff(const std::uint8_t* bytes, std::size_t size, DecodedImage* image);

}  // namespace fringetwin
