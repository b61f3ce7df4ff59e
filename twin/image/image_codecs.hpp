// SPDX-License-Identifier: Apache-2.0
// Decodes BMP, TIFF, PGM through OpenCV, in a module of its own that is loaded when such a file is met: its
// codecs bring 120 shared libraries (GDAL and what it needs), half a second that every start of the program
// would pay.
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

/// The module's only function, by this name.
using DecodeImageFunction = bool (*)(const std::uint8_t* bytes, std::size_t size, DecodedImage* image);
constexpr const char* kDecodeImageName = "fringetwin_decode_image_1";  ///< 1: DecodedImage as it stands here

}  // namespace fringetwin
