// SPDX-License-Identifier: Apache-2.0
#include "capture/device/pixel_format.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <memory>

#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"

namespace fringetwin::capture {
namespace {

constexpr std::array<PixelFormatTraits, 27> kAllFormats{{
    {PixelFormat::y16, "Y16", V4L2_PIX_FMT_Y16, 16, 2, ""},
    {PixelFormat::y16_be, "Y16-BE", V4L2_PIX_FMT_Y16_BE, 16, 2, ""},
    {PixelFormat::y12, "Y12", V4L2_PIX_FMT_Y12, 12, 2, ""},
    {PixelFormat::y10, "Y10", V4L2_PIX_FMT_Y10, 10, 2, ""},
    {PixelFormat::grey, "GREY", V4L2_PIX_FMT_GREY, 8, 1, ""},
    {PixelFormat::yuyv, "YUYV", V4L2_PIX_FMT_YUYV, 8, 2, ""},
    {PixelFormat::mjpg, "MJPG", V4L2_PIX_FMT_MJPEG, 8, 0, ""},
    {PixelFormat::srggb16, "SRGGB16", V4L2_PIX_FMT_SRGGB16, 16, 2, "RGGB"},
    {PixelFormat::sgrbg16, "SGRBG16", V4L2_PIX_FMT_SGRBG16, 16, 2, "GRBG"},
    {PixelFormat::sgbrg16, "SGBRG16", V4L2_PIX_FMT_SGBRG16, 16, 2, "GBRG"},
    {PixelFormat::sbggr16, "SBGGR16", V4L2_PIX_FMT_SBGGR16, 16, 2, "BGGR"},
    {PixelFormat::srggb14, "SRGGB14", V4L2_PIX_FMT_SRGGB14, 14, 2, "RGGB"},
    {PixelFormat::sgrbg14, "SGRBG14", V4L2_PIX_FMT_SGRBG14, 14, 2, "GRBG"},
    {PixelFormat::sgbrg14, "SGBRG14", V4L2_PIX_FMT_SGBRG14, 14, 2, "GBRG"},
    {PixelFormat::sbggr14, "SBGGR14", V4L2_PIX_FMT_SBGGR14, 14, 2, "BGGR"},
    {PixelFormat::srggb12, "SRGGB12", V4L2_PIX_FMT_SRGGB12, 12, 2, "RGGB"},
    {PixelFormat::sgrbg12, "SGRBG12", V4L2_PIX_FMT_SGRBG12, 12, 2, "GRBG"},
    {PixelFormat::sgbrg12, "SGBRG12", V4L2_PIX_FMT_SGBRG12, 12, 2, "GBRG"},
    {PixelFormat::sbggr12, "SBGGR12", V4L2_PIX_FMT_SBGGR12, 12, 2, "BGGR"},
    {PixelFormat::srggb10, "SRGGB10", V4L2_PIX_FMT_SRGGB10, 10, 2, "RGGB"},
    {PixelFormat::sgrbg10, "SGRBG10", V4L2_PIX_FMT_SGRBG10, 10, 2, "GRBG"},
    {PixelFormat::sgbrg10, "SGBRG10", V4L2_PIX_FMT_SGBRG10, 10, 2, "GBRG"},
    {PixelFormat::sbggr10, "SBGGR10", V4L2_PIX_FMT_SBGGR10, 10, 2, "BGGR"},
    {PixelFormat::srggb8, "SRGGB8", V4L2_PIX_FMT_SRGGB8, 8, 1, "RGGB"},
    {PixelFormat::sgrbg8, "SGRBG8", V4L2_PIX_FMT_SGRBG8, 8, 1, "GRBG"},
    {PixelFormat::sgbrg8, "SGBRG8", V4L2_PIX_FMT_SGBRG8, 8, 1, "GBRG"},
    {PixelFormat::sbggr8, "SBGGR8", V4L2_PIX_FMT_SBGGR8, 8, 1, "BGGR"},
}};

bool has_words(PixelFormat format) { return traits(format).bit_depth > 8; }

// The place of a word's low and high byte.
struct WordOrder {
  std::size_t low, high;
};
WordOrder word_order(PixelFormat format) {
  return format == PixelFormat::y16_be ? WordOrder{1, 0} : WordOrder{0, 1};
}

const std::byte* row(std::span<const std::byte> bytes, const FrameLayout& layout, int y) {
  return bytes.data() + static_cast<std::size_t>(y) * layout.bytes_per_line;
}

UnpackedFrame unpack_words(std::span<const std::byte> bytes, const FrameLayout& layout) {
  const WordOrder order = word_order(layout.format);
  const unsigned top = (1u << traits(layout.format).bit_depth) - 1u;
  unsigned seen = 0;
  ImageU16 dn(layout.width, layout.height);
  for (int y = 0; y < layout.height; ++y) {
    const std::byte* from = row(bytes, layout, y);
    std::uint16_t* to = &dn(0, y);
    for (int x = 0; x < layout.width; ++x, from += 2) {
      const unsigned word =
          std::to_integer<unsigned>(from[order.low]) | std::to_integer<unsigned>(from[order.high]) << 8;
      seen |= word;
      to[x] = static_cast<std::uint16_t>(word >> layout.shift);
    }
  }
  if (seen > top) return {{}, FrameFault::undecodable};
  return {std::move(dn), FrameFault::none};
}

UnpackedFrame unpack_bytes(std::span<const std::byte> bytes, const FrameLayout& layout) {
  const int stride = traits(layout.format).bytes_per_pixel;
  ImageU16 dn(layout.width, layout.height);
  for (int y = 0; y < layout.height; ++y) {
    const std::byte* from = row(bytes, layout, y);
    std::uint16_t* to = &dn(0, y);
    for (int x = 0; x < layout.width; ++x, from += stride)
      to[x] = static_cast<std::uint16_t>(std::to_integer<unsigned>(*from) >> layout.shift);
  }
  return {std::move(dn), FrameFault::none};
}

UnpackedFrame unpack_jpeg(std::span<const std::byte> bytes, const FrameLayout& layout) {
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  FT_CHECK(decoder, "turbojpeg starts");
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, subsampling = 0, colours = 0;
  if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &subsampling, &colours) != 0 ||
      width != layout.width || height != layout.height)
    return {{}, FrameFault::undecodable};
  ImageU8 grey(width, height);
  // A truncated stream is only a warning for the decoder, which fills up with grey.
  if (tjDecompress2(decoder.get(), data, bytes.size(), grey.data.data(), width, 0, height, TJPF_GRAY,
                    TJFLAG_STOPONWARNING | TJFLAG_ACCURATEDCT) != 0)
    return {{}, FrameFault::undecodable};
  ImageU16 dn(width, height);
  std::ranges::copy(grey.data, dn.data.begin());
  return {std::move(dn), FrameFault::none};
}

}  // namespace

std::span<const PixelFormatTraits> pixel_formats() { return kAllFormats; }

const PixelFormatTraits& traits(PixelFormat format) {
  return *std::ranges::find(kAllFormats, format, &PixelFormatTraits::format);
}

std::optional<PixelFormat> pixel_format_of_fourcc(std::uint32_t fourcc) {
  if (fourcc == V4L2_PIX_FMT_JPEG) return PixelFormat::mjpg;  // the same bytes under another name
  for (const PixelFormatTraits& t : kAllFormats)
    if (t.fourcc == fourcc) return t.format;
  return std::nullopt;
}

std::optional<PixelFormat> pixel_format_of_name(const std::string& name) {
  for (const PixelFormatTraits& t : kAllFormats)
    if (lower_case(name) == lower_case(t.name)) return t.format;
  return std::nullopt;
}

PixelFormat required_pixel_format(const std::string& name, const std::string& option) {
  if (const auto format = pixel_format_of_name(name)) return *format;
  throw UserError(ExitCode::usage, option, fmt::format("'{}' is no pixel format", name),
                  "choose " + pixel_format_names());
}

std::string pixel_format_names() {
  std::string names;
  for (const PixelFormatTraits& t : kAllFormats) names += (names.empty() ? "" : ", ") + std::string(t.name);
  return names;
}

std::string pixel_format_names(const std::string& mosaic) {
  std::string names;
  for (const PixelFormatTraits& t : kAllFormats)
    if (mosaic == t.mosaic) names += (names.empty() ? "" : ", ") + std::string(t.name);
  return names;
}

std::string fourcc_text(std::uint32_t fourcc) {
  for (const PixelFormatTraits& t : kAllFormats)
    if (t.fourcc == fourcc) return t.name;
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const char c = static_cast<char>(fourcc >> (8 * i) & 0x7f);
    if (c != ' ') text += std::isprint(static_cast<unsigned char>(c)) ? c : '?';
  }
  return text + ((fourcc & 1u << 31) != 0 ? "-BE" : "");
}

// Some drivers hand out their whole buffer, with what the bus needs behind the last line.
FrameFault check_length(std::span<const std::byte> bytes, const FrameLayout& layout) {
  if (layout.format == PixelFormat::mjpg) return bytes.empty() ? FrameFault::wrong_length : FrameFault::none;
  const bool whole = bytes.size() == layout.used_bytes() ||
                     (bytes.size() == layout.size_bytes && layout.size_bytes > layout.used_bytes());
  return whole ? FrameFault::none : FrameFault::wrong_length;
}

UnpackedFrame unpack_frame(std::span<const std::byte> bytes, const FrameLayout& layout) {
  if (const FrameFault fault = check_length(bytes, layout); fault != FrameFault::none) return {{}, fault};
  if (layout.format == PixelFormat::mjpg) return unpack_jpeg(bytes, layout);
  return has_words(layout.format) ? unpack_words(bytes, layout) : unpack_bytes(bytes, layout);
}

void pack_frame(const ImageU16& dn, const FrameLayout& layout, std::span<std::byte> bytes) {
  FT_CHECK(dn.width == layout.width && dn.height == layout.height, "the picture has the layout's size");
  FT_CHECK(layout.format != PixelFormat::mjpg && bytes.size() >= layout.used_bytes(),
           "an uncompressed buffer");
  const int stride = traits(layout.format).bytes_per_pixel;
  const WordOrder order = word_order(layout.format);
  const bool words = has_words(layout.format);
  for (int y = 0; y < layout.height; ++y) {
    std::byte* to = bytes.data() + static_cast<std::size_t>(y) * layout.bytes_per_line;
    for (int x = 0; x < layout.width; ++x, to += stride) {
      const unsigned word = static_cast<unsigned>(dn(x, y)) << layout.shift;
      to[words ? order.low : 0] = static_cast<std::byte>(word & 0xff);
      if (words) to[order.high] = static_cast<std::byte>(word >> 8 & 0xff);
      if (layout.format == PixelFormat::yuyv) to[1] = std::byte{128};
    }
  }
}

}  // namespace fringetwin::capture
