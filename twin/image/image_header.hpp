// SPDX-License-Identifier: Apache-2.0
// Reads from the header of a PNG, BMP, TIFF or PNM file what it will be when it is decoded, as the libraries
// that decode it read it. Nothing is decoded.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>

namespace fringetwin {

struct ImageHeader {
  bool png = false;
  std::uint64_t width = 0, height = 0;  ///< below 2^32 each, may be 0
  int decoding_bytes = 0;               ///< a value takes while it is decoded
  std::uint64_t channels = 1;           ///< values a pixel is decoded to before one colour of it is taken
};

/// Returns nothing where the file is none of these, or its header is cut off, contradicts itself or asks for
/// more memory than the image has pixels.
std::optional<ImageHeader> read_image_header(const std::filesystem::path& file);

}  // namespace fringetwin
