// SPDX-License-Identifier: Apache-2.0
// Converts the bytes of an industrial camera's frame (GenICam's Pixel Format Naming Convention: Mono12p,
// BayerRG10Packed ...) to digital numbers, and back for tests and rehearsals.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "capture/device/pixel_format.hpp"

namespace fringetwin::capture {

/// How pixels lie in bytes.
enum class PfncPacking {
  bytes,   ///< one byte each
  words,   ///< 16 bits each, low byte first, the value in the low bits
  p,       ///< "12p": without a gap, each pixel's lowest bit first (USB3 Vision)
  packed,  ///< "12Packed": two pixels in three bytes, their high bits in the outer bytes (GigE Vision)
};

struct PfncFormat {
  const char* name;    ///< "Mono12p"
  std::uint32_t code;  ///< of the convention, as packets carry it
  int bit_depth;
  PfncPacking packing;
  const char* mosaic;  ///< colours of the first two pixels of a Bayer sensor: "RG"; "" = monochrome

  bool is_mosaic() const { return *mosaic != '\0'; }
  /// Is it the format of a sensor with this mosaic ("RGGB"), or of a monochrome one ("")?
  bool is_of(const std::string& sensor_mosaic) const { return sensor_mosaic.substr(0, 2) == mosaic; }
  int bits_per_pixel() const;
};

/// Monochrome before Bayer, then deepest first; of one depth those first that take the fewest bytes.
std::span<const PfncFormat> pfnc_formats();
const PfncFormat* pfnc_format_of_code(std::uint32_t code);
const PfncFormat* pfnc_format_of_name(const std::string& name);  ///< case does not matter

/// The layout of a frame in memory. Where `lines_are_whole` is false and a line's bits fill no whole bytes,
/// the next one goes on in the middle of a byte (GigE Vision without padding).
struct PfncLayout {
  const PfncFormat* format = nullptr;
  int width = 0, height = 0;
  bool lines_are_whole = false;   ///< each line begins with a byte of its own
  std::size_t line_padding = 0;   ///< bytes behind each line
  std::size_t frame_padding = 0;  ///< bytes behind the last line that a frame may bring along
  int shift = 0;                  ///< a word's lowest bits that carry nothing (Mono16, MSB aligned)

  int bit_depth() const { return format->bit_depth - shift; }
  std::size_t used_bytes() const;  ///< without `frame_padding`
};

/// Returns the fault that the number of bytes shows, without looking at pixels.
FrameFault check_length(std::size_t n_bytes, const PfncLayout& layout);
/// A frame of another length is FrameFault::wrong_length, words with bits beyond their format are
/// FrameFault::undecodable. A Bayer sensor's pixels are given one by one, as they lie on it.
UnpackedFrame unpack_pfnc(std::span<const std::byte> bytes, const PfncLayout& layout);
/// The inverse; `bytes` has layout.used_bytes() at least, padding is left alone.
void pack_pfnc(const ImageU16& dn, const PfncLayout& layout, std::span<std::byte> bytes);

}  // namespace fringetwin::capture
