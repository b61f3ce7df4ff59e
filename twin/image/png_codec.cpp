// SPDX-License-Identifier: Apache-2.0
#include "twin/image/png_codec.hpp"

#include <png.h>
#include <zlib.h>

#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>

#include "twin/base/not_copyable.hpp"

namespace fringetwin {
namespace {

// libpng reports an error by longjmp, which must not skip the destructor of any C++ object. So the
// functions that call setjmp (decode_image, encode_image) hold plain data only; everything
// with a destructor lives in their callers.
struct Message {
  char text[200] = "";
};

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
  auto* message = static_cast<Message*>(png_get_error_ptr(png));
  std::strncpy(message->text, text, sizeof message->text - 1);
  png_longjmp(png, 1);
}
// Warnings (unknown or odd ancillary chunks) do not touch the pixels.
void on_warning(png_structp, png_const_charp) {}

struct Source {
  const std::uint8_t* data;
  std::size_t size, position;
};

void read_bytes(png_structp png, png_bytep out, std::size_t n) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (n > source->size - source->position) png_error(png, "is truncated (the file ends too early)");
  std::memcpy(out, source->data + source->position, n);
  source->position += n;
}

void append_bytes(png_structp png, png_bytep data, std::size_t n) {
  auto* bytes = static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
  bool ok = true;
  try {
    bytes->insert(bytes->end(), data, data + n);
  } catch (...) {  // no exception may cross libpng's C frames
    ok = false;
  }
  if (!ok) png_error(png, "out of memory");
}
void flush_nothing(png_structp) {}

/// Returns why no gray values can be had of an image of this type; empty where they can.
std::string refused_color_type(int color_type, bool channel_is_named) {
  if (color_type == PNG_COLOR_TYPE_GRAY_ALPHA) return "has an alpha channel, a plain gray image is needed";
  if (color_type == PNG_COLOR_TYPE_GRAY || channel_is_named) return "";
  return std::string("is a colour image (") + (color_type == PNG_COLOR_TYPE_PALETTE ? "palette" : "RGB") +
         "), a gray image is needed; " + kNameAColour;
}

struct PngHeader {
  png_uint_32 width, height;
  int bits;
  int color_type;
};

// Reads up to the pixels. False with the message set.
bool decode_header(png_structp png, png_infop info, PngHeader* header) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  // Texts, profiles and the like unpack to 8 MB each, a thousand of them: they are skipped.
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(png, info);
  png_get_IHDR(png, info, &header->width, &header->height, &header->bits, &header->color_type, nullptr,
               nullptr, nullptr);
  png_set_packing(png);  // 1, 2, 4 bit: one byte each, not scaled
  if constexpr (std::endian::native == std::endian::little) {
    if (header->bits == 16) png_set_swap(png);
  }
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  return true;
}

bool decode_image(png_structp png, png_infop info, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_image(png, rows);
  png_read_end(png, info);
  return true;
}

bool encode_image(png_structp png, png_infop info, const PngHeader* header, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_IHDR(png, info, header->width, header->height, header->bits, PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  // Measured on 1440x1080 fringe images, clean to noisy: 14-26 ms and 0.3-0.75 MB (8 bit). The
  // match search of the default strategy costs up to twice the time on noise and finds little.
  png_set_compression_level(png, 1);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
  png_set_compression_strategy(png, Z_RLE);
  png_write_info(png, info);
  if constexpr (std::endian::native == std::endian::little) {
    if (header->bits == 16) png_set_swap(png);
  }
  png_write_image(png, rows);
  png_write_end(png, info);
  return true;
}

std::vector<png_bytep> row_pointers(const std::uint8_t* values, std::size_t height, std::size_t row_bytes) {
  std::vector<png_bytep> rows(height);
  // libpng takes non-const rows also where it only reads them
  for (std::size_t y = 0; y < height; ++y) rows[y] = const_cast<png_bytep>(values + y * row_bytes);
  return rows;
}

struct Reader : NotCopyable {
  Message message;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &message, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};

struct Writer : NotCopyable {
  Message message;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &message, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  ~Writer() { png_destroy_write_struct(&png, &info); }
};

std::string complaint(const Message& message) {
  const std::string text = message.text;
  if (text.rfind("is ", 0) == 0 || text.rfind("has ", 0) == 0) return text;
  return "is damaged (libpng: " + text + ")";
}

/// Turns palette numbers into the values of one colour; false where a number is beyond the palette.
bool look_up_colour(png_structp png, png_infop info, ColourChannel channel,
                    std::vector<std::uint8_t>* values) {
  png_colorp palette = nullptr;
  int n = 0;
  if (png_get_PLTE(png, info, &palette, &n) == 0) return false;
  std::array<std::uint8_t, 256> table{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k)
    table[k] = channel == ColourChannel::red     ? palette[k].red
               : channel == ColourChannel::green ? palette[k].green
                                                 : palette[k].blue;
  for (std::uint8_t& value : *values) {
    if (value >= n) return false;
    value = table[value];
  }
  return true;
}

}  // namespace

bool is_png(const std::vector<std::uint8_t>& bytes) {
  return bytes.size() >= 8 && png_sig_cmp(bytes.data(), 0, 8) == 0;
}

std::string decode_gray_png(const std::vector<std::uint8_t>& bytes,
                            const std::optional<ColourChannel>& channel, GrayPixels* pixels) {
  Reader reader;
  if (reader.info == nullptr) return "cannot be read: out of memory";
  Source source{bytes.data(), bytes.size(), 0};
  png_set_read_fn(reader.png, &source, read_bytes);
  PngHeader header{};
  if (!decode_header(reader.png, reader.info, &header)) return complaint(reader.message);
  const std::string refusal = refused_color_type(header.color_type, channel.has_value());
  if (!refusal.empty()) return refusal;
  pixels->width = static_cast<int>(header.width);  // libpng's own limit is 1e6 a side
  pixels->height = static_cast<int>(header.height);
  pixels->file_bits = header.bits == 16 ? 16 : 8;
  const std::size_t channels = png_get_channels(reader.png, reader.info);
  const std::size_t row_bytes = header.width * channels * (header.bits == 16 ? 2u : 1u);
  pixels->values.resize(row_bytes * header.height);
  std::vector<png_bytep> rows = row_pointers(pixels->values.data(), header.height, row_bytes);
  if (!decode_image(reader.png, reader.info, rows.data())) return complaint(reader.message);
  if (header.color_type == PNG_COLOR_TYPE_PALETTE)
    return look_up_colour(reader.png, reader.info, *channel, &pixels->values)
               ? ""
               : "is damaged (a pixel has a number beyond the palette)";
  if (channels > 1) keep_channel(channels, header.bits, *channel, &pixels->values);
  return "";
}

std::string encode_gray_png(const GrayPixels& pixels, std::vector<std::uint8_t>* bytes) {
  Writer writer;
  if (writer.info == nullptr) return "out of memory";
  bytes->clear();
  bytes->reserve(pixels.values.size());
  png_set_write_fn(writer.png, bytes, append_bytes, flush_nothing);
  const PngHeader header{static_cast<png_uint_32>(pixels.width), static_cast<png_uint_32>(pixels.height),
                         pixels.file_bits, PNG_COLOR_TYPE_GRAY};
  const std::size_t row_bytes = header.width * (header.bits == 16 ? 2u : 1u);
  std::vector<png_bytep> rows = row_pointers(pixels.values.data(), header.height, row_bytes);
  if (!encode_image(writer.png, writer.info, &header, rows.data())) return complaint(writer.message);
  return "";
}

}  // namespace fringetwin
