// SPDX-License-Identifier: Apache-2.0
#include "capture/device/pixel_format.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <turbojpeg.h>

#include <memory>
#include <random>

#include "tests/support/capture/bytes.hpp"

namespace fringetwin::testing::pixel_format_test {
namespace {

using namespace fringetwin::capture;
using ::testing::ElementsAre;

FrameLayout layout_of(PixelFormat format, int width, int height, std::size_t padding = 0) {
  const std::size_t line = static_cast<std::size_t>(width * traits(format).bytes_per_pixel) + padding;
  return {format, width, height, line, line * static_cast<std::size_t>(height), 0};
}

ImageU16 noise(int width, int height, int bits, unsigned seed) {
  std::mt19937 random(seed);
  ImageU16 dn(width, height);
  for (std::uint16_t& value : dn.data) value = static_cast<std::uint16_t>(random() & ((1u << bits) - 1u));
  return dn;
}

TEST(PixelFormat, BytesAreReadAsTheKernelsDocumentationOrdersThem) {
  const auto read = [](PixelFormat format, const Bytes& bytes) {
    return unpack_frame(bytes, layout_of(format, 2, 1)).dn.data;
  };
  EXPECT_THAT(read(PixelFormat::grey, bytes_of({1, 255})), ElementsAre(1, 255));
  EXPECT_THAT(read(PixelFormat::y10, bytes_of({0x34, 0x02, 0xff, 0x03})), ElementsAre(0x234, 1023));
  EXPECT_THAT(read(PixelFormat::y12, bytes_of({0x34, 0x02, 0xff, 0x0f})), ElementsAre(0x234, 4095));
  EXPECT_THAT(read(PixelFormat::y16, bytes_of({0x34, 0x12, 0xff, 0xff})), ElementsAre(0x1234, 65535));
  EXPECT_THAT(read(PixelFormat::y16_be, bytes_of({0x12, 0x34, 0xff, 0xff})), ElementsAre(0x1234, 65535));
  EXPECT_THAT(read(PixelFormat::yuyv, bytes_of({10, 77, 200, 99})), ElementsAre(10, 200));
}

TEST(PixelFormat, PaddedLinesComeBackAsTheyWerePacked) {
  for (const PixelFormatTraits& t : pixel_formats()) {
    if (t.bytes_per_pixel == 0) continue;
    for (const std::size_t padding : {0u, 6u}) {
      const FrameLayout layout = layout_of(t.format, 6, 5, padding);
      const ImageU16 dn = noise(6, 5, t.bit_depth, 7);
      Bytes bytes(layout.size_bytes, std::byte{0xaa});
      pack_frame(dn, layout, bytes);
      for (std::size_t i = 0; i < padding; ++i)
        EXPECT_EQ(bytes[layout.bytes_per_line - 1 - i], std::byte{0xaa}) << t.name;
      const UnpackedFrame back = unpack_frame(bytes, layout);
      EXPECT_EQ(back.fault, FrameFault::none) << t.name;
      EXPECT_EQ(back.dn.data, dn.data) << t.name << " padding " << padding;
    }
  }
}

TEST(PixelFormat, HighAlignedWordsAreShifted) {
  FrameLayout layout = layout_of(PixelFormat::y16, 2, 1);
  layout.shift = 4;
  EXPECT_EQ(layout.bit_depth(), 12);
  EXPECT_THAT(unpack_frame(bytes_of({0xf0, 0xff, 0x40, 0x12}), layout).dn.data, ElementsAre(4095, 0x124));
}

TEST(PixelFormat, WordsBeyondTheFormatAreNoPicture) {
  EXPECT_EQ(unpack_frame(bytes_of({0, 4, 0, 0}), layout_of(PixelFormat::y10, 2, 1)).fault,
            FrameFault::undecodable);
  EXPECT_EQ(unpack_frame(bytes_of({0, 4, 0, 0}), layout_of(PixelFormat::y12, 2, 1)).fault, FrameFault::none);
  EXPECT_EQ(unpack_frame(bytes_of({0, 16, 0, 0}), layout_of(PixelFormat::y12, 2, 1)).fault,
            FrameFault::undecodable);
}

TEST(PixelFormat, EveryOtherLengthIsWrong) {
  for (const PixelFormatTraits& t : pixel_formats()) {
    if (t.bytes_per_pixel == 0) continue;
    FrameLayout layout = layout_of(t.format, 4, 3);
    const std::size_t right = layout.size_bytes;
    layout.size_bytes += 8;  // the driver's buffer is longer than the picture
    for (std::size_t length = 0; length < right + 16; ++length) {
      const UnpackedFrame frame = unpack_frame(Bytes(length), layout);
      const bool sound = length == right || length == right + 8;
      EXPECT_EQ(frame.fault, sound ? FrameFault::none : FrameFault::wrong_length) << t.name << " " << length;
      EXPECT_EQ(frame.dn.empty(), !sound);
    }
  }
  EXPECT_EQ(unpack_frame({}, {PixelFormat::mjpg, 4, 3, 0, 100, 0}).fault, FrameFault::wrong_length);
}

TEST(PixelFormat, NamesAndCodes) {
  for (const PixelFormatTraits& t : pixel_formats()) {
    EXPECT_EQ(pixel_format_of_name(t.name), t.format);
    EXPECT_EQ(pixel_format_of_fourcc(t.fourcc), t.format);
    EXPECT_EQ(fourcc_text(t.fourcc), t.name);
  }
  EXPECT_EQ(pixel_format_of_name("y16-be"), PixelFormat::y16_be);
  EXPECT_EQ(pixel_format_of_name("Y14"), std::nullopt);
  EXPECT_EQ(pixel_format_of_fourcc(V4L2_PIX_FMT_JPEG), PixelFormat::mjpg);
  EXPECT_EQ(fourcc_text(V4L2_PIX_FMT_RGB24), "RGB3");
}

// --- JPEG

constexpr int jpeg_width = 64, jpeg_height = 48;
constexpr FrameLayout jpeg_layout{PixelFormat::mjpg, jpeg_width, jpeg_height, 0, 100000, 0};

struct Jpeg {
  Bytes bytes;
  std::vector<unsigned char> grey;  ///< decoded by the library itself, without any flag of ours
};

Jpeg make_jpeg(int subsampling, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<unsigned char> rgb(3 * jpeg_width * jpeg_height);
  for (unsigned char& value : rgb) value = static_cast<unsigned char>(random());
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(encoder.get(), rgb.data(), jpeg_width, 0, jpeg_height, TJPF_RGB, &data, &size,
                        subsampling, 90, 0),
            0);
  Jpeg jpeg;
  jpeg.bytes.assign(reinterpret_cast<std::byte*>(data), reinterpret_cast<std::byte*>(data) + size);
  jpeg.grey.resize(jpeg_width * jpeg_height);
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  EXPECT_EQ(tjDecompress2(decoder.get(), data, size, jpeg.grey.data(), jpeg_width, 0, jpeg_height, TJPF_GRAY,
                          TJFLAG_ACCURATEDCT),
            0);
  tjFree(data);
  return jpeg;
}

TEST(MotionJpeg, LumaIsTheDecodersAndBytesBehindTheEndDoNotMatter) {
  for (const int subsampling : {TJSAMP_GRAY, TJSAMP_420, TJSAMP_422, TJSAMP_444}) {
    Jpeg jpeg = make_jpeg(subsampling, 3);
    for (const std::size_t behind : {0u, 100u}) {
      jpeg.bytes.resize(jpeg.bytes.size() + behind);
      const UnpackedFrame frame = unpack_frame(jpeg.bytes, jpeg_layout);
      ASSERT_EQ(frame.fault, FrameFault::none);
      EXPECT_TRUE(std::equal(jpeg.grey.begin(), jpeg.grey.end(), frame.dn.data.begin(), frame.dn.data.end()));
    }
  }
}

// Most cameras leave the standard's tables out.
TEST(MotionJpeg, HuffmanTablesMayBeLeftOut) {
  Jpeg jpeg = make_jpeg(TJSAMP_422, 4);
  constexpr std::byte marker{0xff}, table{0xc4};
  int removed = 0;
  for (std::size_t i = 2;
       i + 3 < jpeg.bytes.size() && jpeg.bytes[i] == marker && jpeg.bytes[i + 1] != std::byte{0xda};) {
    const std::size_t length = 2 + (std::to_integer<std::size_t>(jpeg.bytes[i + 2]) << 8 |
                                    std::to_integer<std::size_t>(jpeg.bytes[i + 3]));
    if (jpeg.bytes[i + 1] == table) {
      const auto at = jpeg.bytes.begin() + static_cast<std::ptrdiff_t>(i);
      jpeg.bytes.erase(at, at + static_cast<std::ptrdiff_t>(length));
      ++removed;
    } else {
      i += length;
    }
  }
  ASSERT_GT(removed, 0);
  const UnpackedFrame frame = unpack_frame(jpeg.bytes, jpeg_layout);
  ASSERT_EQ(frame.fault, FrameFault::none);
  EXPECT_TRUE(std::equal(jpeg.grey.begin(), jpeg.grey.end(), frame.dn.data.begin(), frame.dn.data.end()));
}

TEST(MotionJpeg, CutAnywhereItIsUndecodable) {
  const Jpeg jpeg = make_jpeg(TJSAMP_422, 5);
  for (std::size_t length = 1; length < jpeg.bytes.size();
       length += length < jpeg.bytes.size() - 80 ? 7 : 1) {
    const UnpackedFrame frame = unpack_frame(std::span(jpeg.bytes).first(length), jpeg_layout);
    ASSERT_EQ(frame.fault, FrameFault::undecodable) << length << " of " << jpeg.bytes.size();
    ASSERT_TRUE(frame.dn.empty());
  }
}

// What the bus lost in the middle leaves too few blocks, or bits over. A JPEG has no checksum: where the rest
// comes out even by chance, nothing can be seen (6 of these 100).
TEST(MotionJpeg, AHoleIsSeldomMissed) {
  const Jpeg jpeg = make_jpeg(TJSAMP_422, 6);
  std::mt19937 random(8);
  int told = 0;
  for (int i = 0; i < 100; ++i) {
    Bytes holed = jpeg.bytes;
    const auto begin = holed.begin() + static_cast<std::ptrdiff_t>(700 + random() % (holed.size() - 1300));
    holed.erase(begin, begin + 512);
    told += unpack_frame(holed, jpeg_layout).fault == FrameFault::undecodable;
  }
  EXPECT_GE(told, 90);
}

// Not each flipped bit can be seen, but none may do harm.
TEST(MotionJpeg, RandomBytesDoNoHarm) {
  const Jpeg jpeg = make_jpeg(TJSAMP_422, 9);
  std::mt19937 random(10);
  int told = 0;
  for (int i = 0; i < 500; ++i) {
    Bytes bytes = jpeg.bytes;
    for (int k = 0; k < 4; ++k) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    const UnpackedFrame frame = unpack_frame(bytes, jpeg_layout);
    EXPECT_EQ(frame.dn.empty(), frame.fault != FrameFault::none);
    told += frame.fault == FrameFault::undecodable;
  }
  EXPECT_GT(told, 0);
}

TEST(MotionJpeg, AnotherSizeIsUndecodable) {
  const Jpeg jpeg = make_jpeg(TJSAMP_422, 11);
  FrameLayout other = jpeg_layout;
  other.width = 32;
  EXPECT_EQ(unpack_frame(jpeg.bytes, other).fault, FrameFault::undecodable);
}

}  // namespace
}  // namespace fringetwin::testing::pixel_format_test
