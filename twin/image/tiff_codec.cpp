// SPDX-License-Identifier: Apache-2.0
// TIFF through libtiff itself: OpenCV takes an image whose blocks it could not decode for a black one.
#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "twin/image/image_codecs.hpp"

namespace fringetwin {
namespace {

/// A file in memory, as libtiff reads it.
struct TiffBytes {
  const std::uint8_t* data;
  std::size_t size, at;
};

TiffBytes& bytes_of(thandle_t handle) { return *static_cast<TiffBytes*>(handle); }

tmsize_t read_tiff(thandle_t handle, void* out, tmsize_t n) {
  TiffBytes& b = bytes_of(handle);
  const std::size_t left = b.at < b.size ? b.size - b.at : 0;
  const std::size_t taken = std::min(left, static_cast<std::size_t>(std::max<tmsize_t>(n, 0)));
  if (taken > 0) std::memcpy(out, b.data + b.at, taken);
  b.at += taken;
  return static_cast<tmsize_t>(taken);
}
tmsize_t write_tiff(thandle_t, void*, tmsize_t) { return 0; }
toff_t seek_tiff(thandle_t handle, toff_t offset, int whence) {
  TiffBytes& b = bytes_of(handle);
  b.at = static_cast<std::size_t>(offset) + (whence == SEEK_CUR ? b.at : whence == SEEK_END ? b.size : 0);
  return b.at;
}
int close_tiff(thandle_t) { return 0; }
toff_t size_of_tiff(thandle_t handle) { return bytes_of(handle).size; }

using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

std::uint16_t number(TIFF* tiff, std::uint32_t tag) {
  std::uint16_t value = 0;
  TIFFGetFieldDefaulted(tiff, tag, &value);
  return value;
}

bool read_strips(TIFF* tiff, std::size_t row_bytes, DecodedImage* image) {
  std::uint32_t rows = 0;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows);
  const auto height = static_cast<std::uint32_t>(image->height);
  rows = std::clamp(rows, 1U, height);
  for (std::uint32_t y = 0; y < height; y += rows) {
    const auto n = static_cast<tmsize_t>(std::min(rows, height - y) * row_bytes);
    if (TIFFReadEncodedStrip(tiff, y / rows, &image->values[y * row_bytes], n) != n) return false;
  }
  return true;
}

bool read_tiles(TIFF* tiff, std::size_t row_bytes, DecodedImage* image) {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &height);
  const std::size_t pixel_bytes = row_bytes / static_cast<std::size_t>(image->width);
  const std::size_t tile_row_bytes = width * pixel_bytes;
  const tmsize_t tile_bytes = TIFFTileSize(tiff);
  if (height == 0 || tile_row_bytes == 0 || tile_bytes != static_cast<tmsize_t>(height * tile_row_bytes))
    return false;
  std::vector<std::uint8_t> tile(static_cast<std::size_t>(tile_bytes));
  const auto image_height = static_cast<std::size_t>(image->height);
  for (std::size_t y = 0; y < image_height; y += height)
    for (std::size_t x = 0; x < row_bytes; x += tile_row_bytes) {
      const auto number = TIFFComputeTile(tiff, static_cast<std::uint32_t>(x / pixel_bytes),
                                          static_cast<std::uint32_t>(y), 0, 0);
      if (TIFFReadEncodedTile(tiff, number, tile.data(), tile_bytes) != tile_bytes) return false;
      for (std::size_t row = 0; row < std::min<std::size_t>(height, image_height - y); ++row)
        std::memcpy(&image->values[(y + row) * row_bytes + x], &tile[row * tile_row_bytes],
                    std::min(tile_row_bytes, row_bytes - x));
    }
  return true;
}

void invert(DecodedImage* image) {
  for (std::uint8_t& byte : image->values) byte = static_cast<std::uint8_t>(~byte);
}

/// Returns why no colour can be taken of a colour image; empty where one can.
std::string fault_of_colours(TIFF* tiff, int photometric, int channels) {
  if (photometric == PHOTOMETRIC_PALETTE)
    return "is a TIFF with a palette, of which no colour is taken; save it as RGB, or as PNG";
  if (photometric != PHOTOMETRIC_RGB || channels < 3 || channels > 4)
    return "is a TIFF with " + std::to_string(channels) +
           " channels that are not RGB, with or without alpha; save it as RGB, or as PNG";
  if (number(tiff, TIFFTAG_PLANARCONFIG) != PLANARCONFIG_CONTIG)
    return "keeps each colour in a plane of its own; save it with the colours of a pixel side by side, or as "
           "PNG";
  return "";
}

}  // namespace

bool decode_tiff(const std::uint8_t* bytes, std::size_t size, const ColourChannel* wanted,
                 DecodedImage* image) {
  TIFFSetErrorHandler(nullptr);  // the program says what is wrong
  TIFFSetWarningHandler(nullptr);
  TiffBytes source{bytes, size, 0};
  const Tiff tiff(TIFFClientOpen("", "rm", &source, read_tiff, write_tiff, seek_tiff, close_tiff,
                                 size_of_tiff, nullptr, nullptr),
                  TIFFClose);
  if (!tiff) return false;
  std::uint32_t width = 0, height = 0;
  TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
  image->width = static_cast<int>(width);
  image->height = static_cast<int>(height);
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;  // where the tag is missing, as libtiff shows it
  TIFFGetField(tiff.get(), TIFFTAG_PHOTOMETRIC, &photometric);
  const int bits = number(tiff.get(), TIFFTAG_BITSPERSAMPLE);
  image->channels = number(tiff.get(), TIFFTAG_SAMPLESPERPIXEL);
  if (image->channels == 1 && photometric == PHOTOMETRIC_PALETTE) image->channels = 3;
  const bool whole = number(tiff.get(), TIFFTAG_SAMPLEFORMAT) == SAMPLEFORMAT_UINT;
  image->bits = whole && (bits == 8 || bits == 16) ? bits : 0;
  const bool colour = image->channels != 1;
  if (image->bits == 0 || (colour && wanted == nullptr)) return true;
  if (colour) image->fault = fault_of_colours(tiff.get(), photometric, image->channels);
  if (!image->fault.empty()) return true;
  if (width == 0 || height == 0 || (!colour && photometric > PHOTOMETRIC_MINISBLACK) ||
      number(tiff.get(), TIFFTAG_ORIENTATION) != ORIENTATION_TOPLEFT)
    return false;
  const auto channels = static_cast<std::size_t>(image->channels);
  const std::size_t row_bytes = width * channels * static_cast<std::size_t>(bits / 8);
  image->values.resize(row_bytes * height);
  const bool read = TIFFIsTiled(tiff.get()) != 0 ? read_tiles(tiff.get(), row_bytes, image)
                                                 : read_strips(tiff.get(), row_bytes, image);
  if (photometric == PHOTOMETRIC_MINISWHITE) invert(image);
  if (colour) {
    keep_channel(channels, bits, *wanted, &image->values);
    image->channels = 1;
  }
  return read;
}

}  // namespace fringetwin
