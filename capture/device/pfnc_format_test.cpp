// SPDX-License-Identifier: Apache-2.0
// Frames of industrial cameras, bit for bit. The truth is the naming convention's own definition, read bit by
// bit (bit_of), and bytes written by hand from its figures.
#include "capture/device/pfnc_format.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "capture/device/pfnc_unpack.hpp"
#include "tests/support/capture/bytes.hpp"

namespace fringetwin::testing::pfnc_format_test {
namespace {

using namespace fringetwin::capture;
using ::testing::ElementsAre;

Bytes noise(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(n);
  for (std::byte& value : bytes) value = static_cast<std::byte>(random() & 0xff);
  return bytes;
}

const PfncFormat& format(const std::string& name) {
  const PfncFormat* found = pfnc_format_of_name(name);
  EXPECT_NE(found, nullptr) << name;
  return *found;
}

std::vector<std::uint16_t> read(const std::string& name, int width, const Bytes& bytes) {
  return unpack_pfnc(bytes, PfncLayout{.format = &format(name), .width = width, .height = 1}).dn.data;
}

/// The place of bit `bit` of pixel i of a run of pixels, as the convention draws it.
std::size_t place_of_bit(const PfncFormat& f, std::size_t i, int bit) {
  const auto b = static_cast<std::size_t>(bit);
  const auto low_bits = static_cast<std::size_t>(f.bit_depth - 8);
  if (f.packing != PfncPacking::packed)
    return i * static_cast<std::size_t>(f.packing == PfncPacking::words ? 16 : f.bit_depth) + b;
  const std::size_t first = i / 2 * 24;
  return b >= low_bits ? first + 16 * (i % 2) + b - low_bits : first + 8 + 4 * (i % 2) + b;
}

std::uint16_t pixel_bit_by_bit(const PfncFormat& f, const std::byte* from, std::size_t i) {
  unsigned value = 0;
  for (int bit = 0; bit < f.bit_depth; ++bit) {
    const std::size_t at = place_of_bit(f, i, bit);
    value |= (std::to_integer<unsigned>(from[at / 8]) >> at % 8 & 1u) << bit;
  }
  return static_cast<std::uint16_t>(value);
}

/// Clears what a word has beyond its format, which would be refused.
void clear_unused_bits(const PfncFormat& f, Bytes* bytes) {
  if (f.packing != PfncPacking::words) return;
  for (std::size_t i = 1; i < bytes->size(); i += 2)
    (*bytes)[i] &= static_cast<std::byte>((1u << (f.bit_depth - 8)) - 1u);
}

class Vectors {
 public:
  explicit Vectors(bool with) { unpack_without_vectors(!with); }
  ~Vectors() { unpack_without_vectors(false); }
};

TEST(PfncFormat, BytesWrittenByHand) {
  EXPECT_THAT(read("Mono8", 3, bytes_of({0, 7, 255})), ElementsAre(0, 7, 255));
  EXPECT_THAT(read("Mono10", 2, bytes_of({0x34, 0x02, 0xff, 0x03})), ElementsAre(0x234, 1023));
  EXPECT_THAT(read("Mono12", 2, bytes_of({0x34, 0x0a, 0xff, 0x0f})), ElementsAre(0xa34, 4095));
  EXPECT_THAT(read("Mono14", 2, bytes_of({0x34, 0x2a, 0xff, 0x3f})), ElementsAre(0x2a34, 16383));
  EXPECT_THAT(read("Mono16", 2, bytes_of({0x34, 0x12, 0xff, 0xff})), ElementsAre(0x1234, 65535));
  EXPECT_THAT(read("BayerGB16", 2, bytes_of({0x34, 0x12, 0xff, 0xff})), ElementsAre(0x1234, 65535));
  // 0xabc and 0x123 in two orders
  EXPECT_THAT(read("Mono12p", 2, bytes_of({0xbc, 0x3a, 0x12})), ElementsAre(0xabc, 0x123));
  EXPECT_THAT(read("Mono12Packed", 2, bytes_of({0xab, 0x3c, 0x12})), ElementsAre(0xabc, 0x123));
  // 0x2ab, 0x155, 0x001, 0x3fe: each pixel's lowest bit first
  EXPECT_THAT(read("Mono10p", 4, bytes_of({0xab, 0x56, 0x15, 0x80, 0xff})),
              ElementsAre(0x2ab, 0x155, 0x001, 0x3fe));
  // high bits outside, 0x2ab & 3 = 3 and 0x155 & 3 = 1 in the halves of the middle byte
  EXPECT_THAT(read("Mono10Packed", 2, bytes_of({0xaa, 0x13, 0x55})), ElementsAre(0x2ab, 0x155));
}

TEST(PfncFormat, EveryFormatBitForBitInEverySize) {
  for (const bool with_vectors : {true, false}) {
    const Vectors vectors(with_vectors);
    for (const PfncFormat& f : pfnc_formats())
      for (int width = 1; width <= 43; ++width) {
        const PfncLayout layout{.format = &f, .width = width, .height = 3};
        Bytes bytes = noise(layout.used_bytes(), static_cast<unsigned>(width));
        clear_unused_bits(f, &bytes);
        const UnpackedFrame got = unpack_pfnc(bytes, layout);
        ASSERT_EQ(got.fault, FrameFault::none) << f.name << " " << width;
        for (std::size_t i = 0; i < got.dn.size(); ++i)
          ASSERT_EQ(got.dn.data[i], pixel_bit_by_bit(f, bytes.data(), i))
              << f.name << " " << width << " " << i;
      }
  }
}

TEST(PfncFormat, LinesThatBeginWithAByteAndPadding) {
  for (const PfncFormat& f : pfnc_formats())
    for (const int width : {1, 7, 29})
      for (const std::size_t padding : {0u, 3u}) {
        const PfncLayout layout{
            .format = &f, .width = width, .height = 4, .lines_are_whole = true, .line_padding = padding};
        Bytes bytes = noise(layout.used_bytes(), 5);
        if (padding == 0) clear_unused_bits(f, &bytes);
        const std::size_t line = layout.used_bytes() / 4;
        if (padding > 0 && f.packing == PfncPacking::words) bytes.assign(bytes.size(), std::byte{1});
        const UnpackedFrame got = unpack_pfnc(bytes, layout);
        ASSERT_EQ(got.fault, FrameFault::none) << f.name;
        for (int y = 0; y < 4; ++y)
          for (int x = 0; x < width; ++x)
            ASSERT_EQ(got.dn(x, y), pixel_bit_by_bit(f, bytes.data() + static_cast<std::size_t>(y) * line,
                                                     static_cast<std::size_t>(x)))
                << f.name << " " << x << " " << y;
      }
}

// What is behind the last pixel belongs to others; the sanitizers watch it.
TEST(PfncFormat, NoByteIsReadOrWrittenBeyondTheFrame) {
  for (const PfncFormat& f : pfnc_formats())
    for (int width = 1; width <= 40; ++width) {
      const PfncLayout layout{.format = &f, .width = width, .height = 1};
      const auto exact = std::make_unique<std::byte[]>(layout.used_bytes());
      EXPECT_EQ(unpack_pfnc({exact.get(), layout.used_bytes()}, layout).fault, FrameFault::none) << f.name;
    }
}

TEST(PfncFormat, OtherLengthsAreNoPicture) {
  for (const PfncFormat& f : pfnc_formats()) {
    PfncLayout layout{.format = &f, .width = 13, .height = 5};
    const std::size_t whole = layout.used_bytes();
    for (const std::size_t length : {std::size_t{0}, std::size_t{1}, whole - 1, whole + 1}) {
      const UnpackedFrame got = unpack_pfnc(Bytes(length), layout);
      EXPECT_EQ(got.fault, FrameFault::wrong_length) << f.name << " " << length;
      EXPECT_TRUE(got.dn.empty());
    }
    layout.frame_padding = 4;
    EXPECT_EQ(check_length(whole, layout), FrameFault::none);
    EXPECT_EQ(check_length(whole + 4, layout), FrameFault::none);
    EXPECT_EQ(check_length(whole + 3, layout), FrameFault::wrong_length);
  }
}

TEST(PfncFormat, WordsBeyondTheFormatAreNoPicture) {
  const auto fault = [](const std::string& name, int high) {
    return unpack_pfnc(bytes_of({0, high, 0, 0}),
                       PfncLayout{.format = &format(name), .width = 2, .height = 1})
        .fault;
  };
  EXPECT_EQ(fault("Mono10", 4), FrameFault::undecodable);
  EXPECT_EQ(fault("Mono12", 4), FrameFault::none);
  EXPECT_EQ(fault("BayerRG12", 16), FrameFault::undecodable);
  EXPECT_EQ(fault("Mono16", 255), FrameFault::none);
}

TEST(PfncFormat, HighAlignedWordsAreShifted) {
  const PfncLayout layout{.format = &format("Mono16"), .width = 2, .height = 1, .shift = 4};
  EXPECT_EQ(layout.bit_depth(), 12);
  EXPECT_THAT(unpack_pfnc(bytes_of({0xf0, 0xff, 0x40, 0x12}), layout).dn.data, ElementsAre(4095, 0x124));
}

TEST(PfncFormat, PackedPicturesComeBack) {
  std::mt19937 random(3);
  for (const PfncFormat& f : pfnc_formats())
    for (const bool whole_lines : {false, true}) {
      const PfncLayout layout{.format = &f, .width = 21, .height = 5, .lines_are_whole = whole_lines};
      ImageU16 dn(21, 5);
      for (std::uint16_t& value : dn.data)
        value = static_cast<std::uint16_t>(random() & ((1u << f.bit_depth) - 1u));
      Bytes bytes = noise(layout.used_bytes(), 9);
      pack_pfnc(dn, layout, bytes);
      EXPECT_EQ(unpack_pfnc(bytes, layout).dn.data, dn.data) << f.name;
    }
}

TEST(PfncFormat, NamesAndCodesSayTheSame) {
  std::set<std::uint32_t> codes;
  std::set<std::string> names;
  for (const PfncFormat& f : pfnc_formats()) {
    codes.insert(f.code);
    names.insert(f.name);
    const std::string name = f.name;
    EXPECT_NE(name.find(std::to_string(f.bit_depth)), std::string::npos) << name;
    EXPECT_EQ(name.substr(0, 5) == "Bayer", f.is_mosaic()) << name;
    if (f.is_mosaic()) {
      EXPECT_EQ(name.substr(5, 2), f.mosaic);
    }
    EXPECT_EQ(name.ends_with("Packed"), f.packing == PfncPacking::packed) << name;
    EXPECT_EQ(name.ends_with("p"), f.packing == PfncPacking::p) << name;
    EXPECT_EQ(f.code >> 24, 1u) << name;  // one channel
    EXPECT_EQ(f.bits_per_pixel(), f.packing == PfncPacking::words    ? 16
                                  : f.packing == PfncPacking::packed ? 12
                                                                     : f.bit_depth)
        << name;
    EXPECT_EQ(pfnc_format_of_code(f.code), &f);
  }
  EXPECT_EQ(codes.size(), pfnc_formats().size());
  EXPECT_EQ(names.size(), pfnc_formats().size());
  EXPECT_EQ(pfnc_format_of_name("MONO12P"), &format("Mono12p"));
  EXPECT_EQ(pfnc_format_of_name("RGB8"), nullptr);
  EXPECT_EQ(pfnc_format_of_code(0x02180014), nullptr);
}

}  // namespace
}  // namespace fringetwin::testing::pfnc_format_test
