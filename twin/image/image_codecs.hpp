// SPDX-License-Identifier: Apache-2.0
// Decodes BMP, TIFF, PGM and PPM to gray values, in a module of its own that is loaded when such a file is
// met: libtiff brings a dozen shared libraries that every start of the program would pay for.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "twin/image/colour_channel.hpp"

namespace fringetwin {

struct DecodedImage {
  int width = 0, height = 0;
  int channels = 0;  ///< 1 as well once a colour of several was taken
  int bits = 0;      ///< 8 or 16, unsigned; 0: another kind of number
  std::vector<std::uint8_t>
      values;              ///< rows without gaps, native byte order; empty unless gray with 8 or 16 bits
  std::string fault = {};  ///< why no colour could be taken of a file that is whole: "keeps its ..."
};

/// The module's only function, by this name. Takes the bytes of a whole file whose header
/// read_image_header() has taken, and the colour that is taken of a colour image, or nullptr; returns false
/// where it cannot be decoded to its last pixel.
using DecodeImageFunction = bool (*)(const std::uint8_t* bytes, std::size_t size, const ColourChannel* wanted,
                                     DecodedImage* image);
/// 2: DecodedImage and the arguments as they stand here.
constexpr const char* kDecodeImageName = "fringetwin_decode_image_2";

/// What the module does for a TIFF.
bool decode_tiff(const std::uint8_t* bytes, std::size_t size, const ColourChannel* wanted,
                 DecodedImage* image);

}  // namespace fringetwin
