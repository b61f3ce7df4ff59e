// SPDX-License-Identifier: Apache-2.0
#include "capture/device/pfnc_format.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "capture/device/pfnc_unpack.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"

namespace fringetwin::capture {
namespace {

constexpr auto kBytes = PfncPacking::bytes, kWords = PfncPacking::words, kLsb = PfncPacking::p,
               kGige = PfncPacking::packed;

// Names and codes of the convention (PFNC 2.x), those of GigE Vision 1.x among them.
constexpr std::array kPfncFormats{
    PfncFormat{"Mono16", 0x01100007, 16, kWords, ""},
    PfncFormat{"Mono14", 0x01100025, 14, kWords, ""},
    PfncFormat{"Mono12p", 0x010c0047, 12, kLsb, ""},
    PfncFormat{"Mono12Packed", 0x010c0006, 12, kGige, ""},
    PfncFormat{"Mono12", 0x01100005, 12, kWords, ""},
    PfncFormat{"Mono10p", 0x010a0046, 10, kLsb, ""},
    PfncFormat{"Mono10Packed", 0x010c0004, 10, kGige, ""},
    PfncFormat{"Mono10", 0x01100003, 10, kWords, ""},
    PfncFormat{"Mono8", 0x01080001, 8, kBytes, ""},
    PfncFormat{"BayerGR16", 0x0110002e, 16, kWords, "GR"},
    PfncFormat{"BayerRG16", 0x0110002f, 16, kWords, "RG"},
    PfncFormat{"BayerGB16", 0x01100030, 16, kWords, "GB"},
    PfncFormat{"BayerBG16", 0x01100031, 16, kWords, "BG"},
    PfncFormat{"BayerGR12p", 0x010c0057, 12, kLsb, "GR"},
    PfncFormat{"BayerRG12p", 0x010c0059, 12, kLsb, "RG"},
    PfncFormat{"BayerGB12p", 0x010c0055, 12, kLsb, "GB"},
    PfncFormat{"BayerBG12p", 0x010c0053, 12, kLsb, "BG"},
    PfncFormat{"BayerGR12Packed", 0x010c002a, 12, kGige, "GR"},
    PfncFormat{"BayerRG12Packed", 0x010c002b, 12, kGige, "RG"},
    PfncFormat{"BayerGB12Packed", 0x010c002c, 12, kGige, "GB"},
    PfncFormat{"BayerBG12Packed", 0x010c002d, 12, kGige, "BG"},
    PfncFormat{"BayerGR12", 0x01100010, 12, kWords, "GR"},
    PfncFormat{"BayerRG12", 0x01100011, 12, kWords, "RG"},
    PfncFormat{"BayerGB12", 0x01100012, 12, kWords, "GB"},
    PfncFormat{"BayerBG12", 0x01100013, 12, kWords, "BG"},
    PfncFormat{"BayerGR10p", 0x010a0056, 10, kLsb, "GR"},
    PfncFormat{"BayerRG10p", 0x010a0058, 10, kLsb, "RG"},
    PfncFormat{"BayerGB10p", 0x010a0054, 10, kLsb, "GB"},
    PfncFormat{"BayerBG10p", 0x010a0052, 10, kLsb, "BG"},
    PfncFormat{"BayerGR10Packed", 0x010c0026, 10, kGige, "GR"},
    PfncFormat{"BayerRG10Packed", 0x010c0027, 10, kGige, "RG"},
    PfncFormat{"BayerGB10Packed", 0x010c0028, 10, kGige, "GB"},
    PfncFormat{"BayerBG10Packed", 0x010c0029, 10, kGige, "BG"},
    PfncFormat{"BayerGR10", 0x0110000c, 10, kWords, "GR"},
    PfncFormat{"BayerRG10", 0x0110000d, 10, kWords, "RG"},
    PfncFormat{"BayerGB10", 0x0110000e, 10, kWords, "GB"},
    PfncFormat{"BayerBG10", 0x0110000f, 10, kWords, "BG"},
    PfncFormat{"BayerGR8", 0x01080008, 8, kBytes, "GR"},
    PfncFormat{"BayerRG8", 0x01080009, 8, kBytes, "RG"},
    PfncFormat{"BayerGB8", 0x0108000a, 8, kBytes, "GB"},
    PfncFormat{"BayerBG8", 0x0108000b, 8, kBytes, "BG"},
};

std::size_t bytes_of_pixels(const PfncFormat& format, std::size_t n) {
  return (n * static_cast<std::size_t>(format.bits_per_pixel()) + 7) / 8;
}

/// The runs of pixels that begin with a whole byte: lines, or the frame as one.
struct Runs {
  std::size_t n_runs, pixels, bytes, stride;
};
Runs runs_of(const PfncLayout& layout) {
  const auto width = static_cast<std::size_t>(layout.width), height = static_cast<std::size_t>(layout.height);
  const std::size_t line = bytes_of_pixels(*layout.format, width);
  if (layout.lines_are_whole || layout.line_padding > 0)
    return {height, width, line, line + layout.line_padding};
  const std::size_t whole = bytes_of_pixels(*layout.format, width * height);
  return {1, width * height, whole, whole};
}

void unpack_run(const PfncLayout& layout, const std::uint8_t* from, std::size_t n, std::uint16_t* to,
                unsigned* seen) {
  const bool ten = layout.format->bit_depth == 10;
  switch (layout.format->packing) {
    case kBytes:
      for (std::size_t i = 0; i < n; ++i) to[i] = from[i];
      return;
    case kWords:
      *seen |= unpack_words(from, n, layout.shift, to);
      return;
    case kLsb:
      return ten ? unpack_10p(from, n, to) : unpack_12p(from, n, to);
    case kGige:
      return ten ? unpack_10packed(from, n, to) : unpack_12packed(from, n, to);
  }
}

// Bit by bit: the slow and plain way, which serves the tests of the fast one.
void set_bits(std::uint8_t* to, std::size_t first_bit, unsigned value, int n_bits) {
  for (int i = 0; i < n_bits; ++i) {
    const std::size_t at = first_bit + static_cast<std::size_t>(i);
    const auto mask = static_cast<std::uint8_t>(1u << at % 8);
    to[at / 8] = static_cast<std::uint8_t>((value >> i & 1u) != 0 ? to[at / 8] | mask : to[at / 8] & ~mask);
  }
}

void pack_pixel(const PfncFormat& format, unsigned value, std::size_t i, std::uint8_t* to) {
  const std::size_t bits = static_cast<std::size_t>(format.bits_per_pixel());
  if (format.packing != kGige) return set_bits(to, i * bits, value, static_cast<int>(bits));
  const int low_bits = format.bit_depth - 8;
  const std::size_t triple = i / 2 * 3;
  to[triple + i % 2 * 2] = static_cast<std::uint8_t>(value >> low_bits);
  set_bits(to, 8 * (triple + 1) + 4 * (i % 2), value & ((1u << low_bits) - 1u), 4);
}

}  // namespace

int PfncFormat::bits_per_pixel() const { return static_cast<int>(code >> 16 & 0xff); }

std::span<const PfncFormat> pfnc_formats() { return kPfncFormats; }

const PfncFormat* pfnc_format_of_code(std::uint32_t code) {
  const auto found = std::ranges::find(kPfncFormats, code, &PfncFormat::code);
  return found == kPfncFormats.end() ? nullptr : &*found;
}

const PfncFormat* pfnc_format_of_name(const std::string& name) {
  const auto found = std::ranges::find_if(
      kPfncFormats, [&](const PfncFormat& format) { return lower_case(format.name) == lower_case(name); });
  return found == kPfncFormats.end() ? nullptr : &*found;
}

std::size_t PfncLayout::used_bytes() const {
  const Runs runs = runs_of(*this);
  return runs.n_runs * runs.stride;
}

FrameFault check_length(std::size_t n_bytes, const PfncLayout& layout) {
  const std::size_t used = layout.used_bytes();
  return n_bytes == used || n_bytes == used + layout.frame_padding ? FrameFault::none
                                                                   : FrameFault::wrong_length;
}

UnpackedFrame unpack_pfnc(std::span<const std::byte> bytes, const PfncLayout& layout) {
  if (const FrameFault fault = check_length(bytes.size(), layout); fault != FrameFault::none)
    return {{}, fault};
  const Runs runs = runs_of(layout);
  ImageU16 dn(layout.width, layout.height);
  const auto* from = reinterpret_cast<const std::uint8_t*>(bytes.data());
  unsigned seen = 0;
  for (std::size_t i = 0; i < runs.n_runs; ++i)
    unpack_run(layout, from + i * runs.stride, runs.pixels, dn.data.data() + i * runs.pixels, &seen);
  if (seen >> layout.format->bit_depth != 0) return {{}, FrameFault::undecodable};
  return {std::move(dn), FrameFault::none};
}

void pack_pfnc(const ImageU16& dn, const PfncLayout& layout, std::span<std::byte> bytes) {
  FT_CHECK(dn.width == layout.width && dn.height == layout.height, "the picture has the layout's size");
  FT_CHECK(bytes.size() >= layout.used_bytes(), "the buffer is large enough");
  const Runs runs = runs_of(layout);
  auto* to = reinterpret_cast<std::uint8_t*>(bytes.data());
  for (std::size_t i = 0; i < runs.n_runs; ++i) {
    std::fill_n(to + i * runs.stride, runs.bytes, std::uint8_t{0});
    for (std::size_t k = 0; k < runs.pixels; ++k)
      pack_pixel(*layout.format, static_cast<unsigned>(dn.data[i * runs.pixels + k]) << layout.shift, k,
                 to + i * runs.stride);
  }
}

}  // namespace fringetwin::capture
