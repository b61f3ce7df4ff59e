// SPDX-License-Identifier: Apache-2.0
#include "report/png.hpp"

#include <png.h>

#include <algorithm>

#include "twin/base/errors.hpp"

namespace fringetwin::report {
namespace {

void append(png_structp png, png_bytep bytes, png_size_t n) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), n);
}
void flush(png_structp) {}

[[noreturn]] void fail(png_structp, png_const_charp message) {
  detail::check_failed("libpng", __FILE__, __LINE__, message);
}
void ignore(png_structp, png_const_charp) {}

void write_text_chunks(png_structp png, png_infop info,
                       const std::vector<std::pair<std::string, std::string>>& text) {
  std::vector<png_text> chunks;
  for (const auto& [key, value] : text) {
    png_text chunk{};
    // tEXt is Latin-1 by the standard; what is not ASCII goes as UTF-8 into iTXt
    const bool ascii = std::ranges::all_of(value, [](char c) { return static_cast<unsigned char>(c) < 127; });
    chunk.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    chunk.key = const_cast<char*>(key.c_str());
    chunk.text = const_cast<char*>(value.c_str());
    (ascii ? chunk.text_length : chunk.itxt_length) = value.size();
    chunks.push_back(chunk);
  }
  if (!chunks.empty()) png_set_text(png, info, chunks.data(), static_cast<int>(chunks.size()));
}

}  // namespace

std::string encode_palette_png(const ImageU8& indices, const std::array<Rgb, 256>& palette,
                               const std::vector<std::pair<std::string, std::string>>& text) {
  FT_CHECK(indices.width > 0 && indices.height > 0, "a PNG needs at least one pixel");
  std::string out;
  // the error handler throws, so no setjmp: what libpng owns is released by the guard
  struct Writer {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, ignore);
    png_infop info = png_create_info_struct(png);
    ~Writer() { png_destroy_write_struct(&png, &info); }
  } writer;
  png_set_write_fn(writer.png, &out, append, flush);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(indices.width),
               static_cast<png_uint_32>(indices.height), 8, PNG_COLOR_TYPE_PALETTE, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  std::array<png_color, 256> colors;
  for (std::size_t i = 0; i < 256; ++i) colors[i] = {palette[i].r, palette[i].g, palette[i].b};
  png_set_PLTE(writer.png, writer.info, colors.data(), 256);
  write_text_chunks(writer.png, writer.info, text);
  png_set_compression_level(writer.png, 5);
  png_set_filter(writer.png, 0, PNG_FILTER_NONE | PNG_FILTER_SUB | PNG_FILTER_UP);
  png_write_info(writer.png, writer.info);
  for (int y = 0; y < indices.height; ++y) png_write_row(writer.png, &indices.data[indices.index(0, y)]);
  png_write_end(writer.png, writer.info);
  return out;
}

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return i + k < bytes.size() ? static_cast<unsigned>(static_cast<unsigned char>(bytes[i + k])) : 0u;
    };
    const unsigned word = (byte(0) << 16) | (byte(1) << 8) | byte(2);
    for (unsigned k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? kDigits[(word >> (18 - 6 * k)) & 63u] : '=';
  }
  return out;
}

std::string png_data_uri(const std::string& png) { return "data:image/png;base64," + base64(png); }

}  // namespace fringetwin::report
