// SPDX-License-Identifier: Apache-2.0
// Converts the bytes of a video device's frame to digital numbers, and back for a display.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "capture/device/camera_device.hpp"

namespace fringetwin::capture {

// clang-format off
enum class PixelFormat {
  y16, y16_be, y12, y10, grey, yuyv, mjpg,
  srggb16, sgrbg16, sgbrg16, sbggr16,
  srggb14, sgrbg14, sgbrg14, sbggr14,
  srggb12, sgrbg12, sgbrg12, sbggr12,
  srggb10, sgrbg10, sgbrg10, sbggr10,
  srggb8, sgrbg8, sgbrg8, sbggr8,
};
// clang-format on

struct PixelFormatTraits {
  PixelFormat format;
  const char* name;      ///< "Y16-BE", as the user writes it
  std::uint32_t fourcc;  ///< V4L2_PIX_FMT_...
  int bit_depth;
  int bytes_per_pixel;  ///< 0: compressed
  const char* mosaic;   ///< colours of a Bayer sensor's first four pixels, "RGGB"; "" = monochrome
};

/// Monochrome before Bayer, deepest first, uncompressed before compressed: the order in which an unnamed
/// format is chosen.
std::span<const PixelFormatTraits> pixel_formats();
const PixelFormatTraits& traits(PixelFormat format);
std::optional<PixelFormat> pixel_format_of_fourcc(std::uint32_t fourcc);
std::optional<PixelFormat> pixel_format_of_name(const std::string& name);  ///< case does not matter
/// Throws UserError(usage) for a name that is none.
PixelFormat required_pixel_format(const std::string& name, const std::string& option);
std::string pixel_format_names();  ///< "Y16, Y16-BE, ..."
/// Those of one mosaic; "": monochrome.
std::string pixel_format_names(const std::string& mosaic);
std::string fourcc_text(std::uint32_t fourcc);  ///< "Y16-BE", "RGB3": also unknown ones

/// The layout of a frame in memory.
struct FrameLayout {
  PixelFormat format = PixelFormat::grey;
  int width = 0, height = 0;
  std::size_t bytes_per_line = 0;  ///< with padding; 0 for a compressed format
  std::size_t size_bytes = 0;      ///< of a whole buffer as the driver has it
  int shift = 0;  ///< a word's lowest bits that carry nothing (12 of 16 bits, MSB aligned: 4)

  int bit_depth() const { return traits(format).bit_depth - shift; }
  std::size_t used_bytes() const { return bytes_per_line * static_cast<std::size_t>(height); }
};

struct UnpackedFrame {
  ImageU16 dn;  ///< empty when faulty
  FrameFault fault = FrameFault::none;
};

/// Returns the fault that the number of bytes shows, without looking at pixels.
FrameFault check_length(std::span<const std::byte> bytes, const FrameLayout& layout);
/// YUYV and MJPG give the luma, a Bayer sensor's pixels are given one by one, as they lie on it. A JPEG with
/// any warning of the decoder, and a word with bits beyond its format, are FrameFault::undecodable.
UnpackedFrame unpack_frame(std::span<const std::byte> bytes, const FrameLayout& layout);

/// The inverse for uncompressed formats, chroma neutral. `bytes` has layout.used_bytes() at least; padding is
/// left alone.
void pack_frame(const ImageU16& dn, const FrameLayout& layout, std::span<std::byte> bytes);

}  // namespace fringetwin::capture
