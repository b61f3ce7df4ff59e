// SPDX-License-Identifier: Apache-2.0
// One colour of colour images: of each format, put together here from plain bytes, exactly the values that
// were put in, whatever the size leaves at the ends of the rows.
//
// | check            | tolerance | origin                                  |
// |------------------|-----------|-----------------------------------------|
// | values           | exact     | integers below 2^16 are stored as such  |
#include "twin/image/colour_channel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/expect_user_error.hpp"
#include "tests/support/twin/png_bytes.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::testing::colour_channel_test {
namespace {
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;

constexpr int kHeight = 3;
constexpr std::array kColours = {ColourChannel::red, ColourChannel::green, ColourChannel::blue};

/// Returns the value of one colour of pixel `k`, another for each colour and pixel.
std::uint32_t value_of(char colour, int k, int bits) {
  const std::uint32_t place = colour == 'r' ? 1 : colour == 'g' ? 2 : colour == 'b' ? 3 : 5;
  return (bits == 16 ? 0x1100 : 40) * place + static_cast<std::uint32_t>(k);
}

std::string number(std::uint32_t value, int bytes, bool high_first) {
  std::string out;
  for (int k = 0; k < bytes; ++k) out += static_cast<char>(value >> (8 * (high_first ? bytes - 1 - k : k)));
  return out;
}
std::string low_first(std::uint32_t value, int bytes) { return number(value, bytes, false); }

/// Returns row `y` of an image, pixel by pixel in the order of `colours` ("rgba": a is the alpha).
std::string row_of(int y, int width, const std::string& colours, int bits, bool high_first) {
  std::string out;
  for (int x = 0; x < width; ++x)
    for (const char colour : colours)
      out += number(value_of(colour, y * width + x, bits), bits / 8, high_first);
  return out;
}
std::string rows_of(int width, const std::string& colours, int bits, bool high_first) {
  std::string out;
  for (int y = 0; y < kHeight; ++y) out += row_of(y, width, colours, bits, high_first);
  return out;
}

class ColourChannelFiles : public ::testing::Test {
 protected:
  LoadedGray read(const std::string& bytes, int width, const std::optional<ColourChannel>& channel) const {
    return read_gray(folder_.write("image", bytes), RightSize{width, kHeight, "the test", ""}, channel);
  }
  void expect_colours(const std::string& bytes, int width, int bits) const {
    for (const ColourChannel channel : kColours) {
      std::vector<float> expected;
      for (int k = 0; k < width * kHeight; ++k)
        expected.push_back(static_cast<float>(value_of(colour_channel_name(channel)[0], k, bits)));
      const LoadedGray loaded = read(bytes, width, channel);
      EXPECT_EQ(loaded.file_bits, bits);
      EXPECT_THAT(loaded.image.data, ElementsAreArray(expected)) << colour_channel_name(channel);
    }
    expect_user_error(ExitCode::input, "is a colour image", [&] { read(bytes, width, {}); });
    expect_user_error(ExitCode::input, "channel = \"green\" in capture.toml",
                      [&] { read(bytes, width, {}); });
  }
  void expect_refused(const std::string& bytes, const std::string& why) const {
    expect_user_error(ExitCode::input, why, [&] { read(bytes, 2, ColourChannel::green); });
  }

  ScratchFolder folder_;
};

TEST_F(ColourChannelFiles, NamesAreThoseOfTheirColours) {
  EXPECT_EQ(colour_channel_of("red"), ColourChannel::red);
  EXPECT_EQ(colour_channel_of("green"), ColourChannel::green);
  EXPECT_EQ(colour_channel_of("blue"), ColourChannel::blue);
  EXPECT_EQ(colour_channel_of(""), std::nullopt);
  EXPECT_EQ(colour_channel_of(std::nullopt), std::nullopt);
}

TEST_F(ColourChannelFiles, Png) {
  for (const int bits : {8, 16})
    for (const int width : {1, 2, 5}) {
      expect_colours(png_bytes({width, kHeight, bits, 2}, rows_of(width, "rgb", bits, true)), width, bits);
      expect_colours(png_bytes({width, kHeight, bits, 6}, rows_of(width, "rgba", bits, true)), width, bits);
    }
  // A colour that stands for "transparent" is a colour.
  const std::string key = png_chunk("tRNS", std::string("\0\x28\0\x50\0\x78", 6));
  expect_colours(png_bytes({2, kHeight, 8, 2}, rows_of(2, "rgb", 8, true), key), 2, 8);
}

TEST_F(ColourChannelFiles, PngWithAPalette) {
  const std::string palette = png_chunk("PLTE", rows_of(2, "rgb", 8, true));  // 6 colours
  const std::string alpha = png_chunk("tRNS", std::string("\0\1\2", 3));
  expect_colours(png_bytes({2, kHeight, 8, 3}, std::string("\0\1\2\3\4\5", 6), palette + alpha), 2, 8);
  expect_colours(png_bytes({2, kHeight, 4, 3}, "\x01\x23\x45", palette), 2, 8);
  expect_refused(png_bytes({2, kHeight, 8, 3}, std::string("\0\1\2\3\4\6", 6), palette),
                 "is damaged (a pixel has a number beyond the palette)");
  expect_refused(png_bytes({2, kHeight, 8, 3}, std::string("\0\1\2\3\4\5", 6)), "is damaged (libpng: ");
}

/// The head of a BMP; `more` stands between it and the pixels.
std::string bmp(int width, int height, int bits, int compression, const std::string& more,
                const std::string& pixels, int info_bytes = 40) {
  const auto data = static_cast<std::uint32_t>(54 + more.size());
  return "BM" + low_first(static_cast<std::uint32_t>(data + pixels.size()), 4) + low_first(0, 4) +
         low_first(data, 4) + low_first(static_cast<std::uint32_t>(info_bytes), 4) +
         low_first(static_cast<std::uint32_t>(width), 4) + low_first(static_cast<std::uint32_t>(height), 4) +
         low_first(1, 2) + low_first(static_cast<std::uint32_t>(bits), 2) +
         low_first(static_cast<std::uint32_t>(compression), 4) + std::string(20, '\0') + more + pixels;
}
/// Rows filled up to four bytes with what is no pixel.
std::string bmp_rows(int width, const std::string& colours, bool top_first) {
  std::string out;
  for (int k = 0; k < kHeight; ++k) {
    out += row_of(top_first ? k : kHeight - 1 - k, width, colours, 8, false);
    while (out.size() % 4 != 0) out += '\xee';
  }
  return out;
}

TEST_F(ColourChannelFiles, Bmp) {
  for (const int width : {1, 2, 3, 4, 5}) {
    expect_colours(bmp(width, kHeight, 24, 0, "", bmp_rows(width, "bgr", false)), width, 8);
    expect_colours(bmp(width, -kHeight, 24, 0, "", bmp_rows(width, "bgr", true)), width, 8);
    expect_colours(bmp(width, kHeight, 32, 0, "", bmp_rows(width, "bgra", false)), width, 8);
  }
  const std::string masks = low_first(0xff, 4) + low_first(0xff00, 4) + low_first(0xff0000, 4);
  expect_colours(bmp(2, kHeight, 32, 3, masks, bmp_rows(2, "rgba", false)), 2, 8);
  const std::string head_of_108 = masks + low_first(0xff000000, 4) + std::string(52, '\0');
  expect_colours(bmp(2, -kHeight, 32, 3, head_of_108, bmp_rows(2, "rgba", true), 108), 2, 8);
  // The header of OS/2 has 12 bytes.
  const std::string pixels = bmp_rows(3, "bgr", false);
  expect_colours("BM" + std::string(8, '\0') + low_first(26, 4) + low_first(12, 4) + low_first(3, 2) +
                     low_first(kHeight, 2) + low_first(1, 2) + low_first(24, 2) + pixels,
                 3, 8);
}

TEST_F(ColourChannelFiles, BmpWithAPalette) {
  std::string palette = rows_of(2, "bgra", 8, false);  // 6 colours
  palette.resize(1024);
  const std::string pixels("\4\5\xee\xee\2\3\xee\xee\0\1\xee\xee", 12);
  expect_colours(bmp(2, kHeight, 8, 0, palette, pixels), 2, 8);
}

TEST_F(ColourChannelFiles, BmpThatIsRefused) {
  const std::string pixels(64, '\1');
  expect_refused(bmp(2, kHeight, 16, 0, "", pixels), "is a BMP whose colours are no bytes of their own");
  const std::string ten_bits = low_first(0x3ff00000, 4) + low_first(0xffc00, 4) + low_first(0x3ff, 4);
  expect_refused(bmp(2, kHeight, 32, 3, ten_bits, pixels),
                 "is a BMP whose colours are no bytes of their own");
  expect_refused(bmp(2, kHeight, 24, 1, "", pixels), "is a BMP whose colours are no bytes of their own");
  expect_refused(bmp(2, kHeight, 24, 0, "", bmp_rows(2, "bgr", false).substr(0, 21)), "is truncated");
}

struct TiffKind {
  int bits = 8;
  bool high_first = false;
  bool tiled = false;
  std::uint32_t photometric = 2;  ///< RGB
  std::uint32_t planar = 1;       ///< side by side
  std::uint32_t sample_format = 1;
};
/// Uncompressed, in strips of one row or in one tile of 16 x 16.
std::string tiff(int width, const std::string& colours, const TiffKind& kind) {
  const auto n = static_cast<std::uint32_t>(colours.size());
  std::vector<std::string> blocks;
  for (int y = 0; y < kHeight; ++y) blocks.push_back(row_of(y, width, colours, kind.bits, kind.high_first));
  if (kind.tiled) {
    std::string tile;
    for (int y = 0; y < 16; ++y) {
      if (y < kHeight) tile += blocks[static_cast<std::size_t>(y)];
      tile.resize(static_cast<std::size_t>(y + 1) * 16 * n * static_cast<std::size_t>(kind.bits) / 8, '\xee');
    }
    blocks = {tile};
  }
  struct Entry {
    std::uint32_t tag, type;  // 3: of 16 bits, 4: of 32
    std::vector<std::uint32_t> values;
  };
  const auto block_bytes = static_cast<std::uint32_t>(blocks.front().size());
  std::vector<Entry> entries = {
      {256, 3, {static_cast<std::uint32_t>(width)}},
      {257, 3, {kHeight}},
      {258, 3, std::vector<std::uint32_t>(n, static_cast<std::uint32_t>(kind.bits))},
      {259, 3, {1}},
      {262, 3, {kind.photometric}},
      {277, 3, {n}},
      {284, 3, {kind.planar}}};
  const std::vector<std::uint32_t> places(blocks.size());  // filled in below
  const std::vector<std::uint32_t> sizes(blocks.size(), block_bytes);
  if (kind.tiled)
    entries.insert(entries.end(), {{322, 3, {16}}, {323, 3, {16}}, {324, 4, places}, {325, 4, sizes}});
  else
    entries.insert(entries.end(), {{273, 4, places}, {278, 3, {1}}, {279, 4, sizes}});
  if (kind.photometric == 3) entries.push_back({320, 3, std::vector<std::uint32_t>(768, 7)});
  if (n == 4) entries.push_back({338, 3, {2}});  // the fourth is an alpha
  entries.push_back({339, 3, std::vector<std::uint32_t>(n, kind.sample_format)});
  std::ranges::sort(entries, {}, &Entry::tag);

  const auto put = [&](std::uint32_t value, int bytes) { return number(value, bytes, kind.high_first); };
  const auto bytes_of = [](const Entry& e) {
    return static_cast<std::uint32_t>(e.values.size() * (e.type == 3 ? 2 : 4));
  };
  std::uint32_t beside = 8 + 2 + 12 * static_cast<std::uint32_t>(entries.size()) + 4, data = beside;
  for (const Entry& e : entries)
    if (bytes_of(e) > 4) data += bytes_of(e);
  for (Entry& e : entries)
    if (e.tag == 273 || e.tag == 324)
      for (std::size_t k = 0; k < e.values.size(); ++k)
        e.values[k] = data + static_cast<std::uint32_t>(k) * block_bytes;
  std::string file = (kind.high_first ? "MM" : "II") + put(42, 2) + put(8, 4) +
                     put(static_cast<std::uint32_t>(entries.size()), 2);
  std::string lists;
  for (const Entry& e : entries) {
    std::string values;
    for (const std::uint32_t value : e.values) values += put(value, e.type == 3 ? 2 : 4);
    file += put(e.tag, 2) + put(e.type, 2) + put(static_cast<std::uint32_t>(e.values.size()), 4);
    if (values.size() > 4) {
      file += put(beside + static_cast<std::uint32_t>(lists.size()), 4);
      lists += values;
    } else {
      values.resize(4);
      file += values;
    }
  }
  file += put(0, 4) + lists;
  for (const std::string& block : blocks) file += block;
  return file;
}

TEST_F(ColourChannelFiles, Tiff) {
  for (const int bits : {8, 16})
    for (const bool high_first : {false, true})
      for (const bool tiled : {false, true})
        for (const std::string colours : {"rgb", "rgba"})
          for (const int width : {1, 5, 16})
            expect_colours(tiff(width, colours, {.bits = bits, .high_first = high_first, .tiled = tiled}),
                           width, bits);
}

TEST_F(ColourChannelFiles, TiffThatIsRefused) {
  expect_refused(tiff(2, "rgb", {.planar = 2}), "keeps each colour in a plane of its own");
  expect_refused(tiff(2, "rgb", {.photometric = 6}), "is a TIFF with 3 channels that are not RGB");
  expect_refused(tiff(2, "rgba", {.photometric = 5}), "is a TIFF with 4 channels that are not RGB");
  expect_refused(tiff(2, "rgbaa", {}), "is a TIFF with 5 channels that are not RGB");
  expect_refused(tiff(2, "ra", {.photometric = 1}), "is a TIFF with 2 channels that are not RGB");
  expect_refused(tiff(2, "r", {.photometric = 3}), "is a TIFF with a palette, of which no colour is taken");
  expect_refused(tiff(2, "rgb", {.bits = 16, .sample_format = 2}), "does not hold 8 or 16 bit unsigned");
  const std::string whole = tiff(2, "rgb", {});
  expect_refused(whole.substr(0, whole.size() - 1), "is truncated");
}

TEST_F(ColourChannelFiles, Ppm) {
  for (const int width : {1, 2, 5}) {
    const std::string size = std::to_string(width) + " " + std::to_string(kHeight);
    expect_colours("P6\n# by a camera\n" + size + "\n255\n" + rows_of(width, "rgb", 8, true), width, 8);
    expect_colours("P6 " + size + " 65535\n" + rows_of(width, "rgb", 16, true), width, 16);
    expect_colours("P6 " + size + " 16383\n" + rows_of(width, "rgb", 16, true), width, 16);
  }
  expect_refused("P6 2 3 255\n" + rows_of(2, "rgb", 8, true).substr(1), "is truncated");
  expect_refused("P6 2 3 0\n" + rows_of(2, "rgb", 8, true), "is no image that can be decoded");
  expect_refused("P3 2 3 255\n1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3\n",
                 "is a colour image as decimal text (P3); save it as binary PPM (P6), or as PNG");
}

TEST_F(ColourChannelFiles, GrayImagesStayAsTheyAre) {
  const std::string six = "\1\2\3\4\5\6";
  std::string palette;
  for (std::uint32_t gray = 0; gray < 256; ++gray) palette += low_first(0x10101 * gray, 4);
  const std::string bmp_pixels("\5\6\0\0\3\4\0\0\1\2\0\0", 12);
  for (const std::string& bytes :
       {png_bytes({2, kHeight, 8, 0}, six), "P5 2 3 255\n" + six, std::string("P2 2 3 255\n1 2 3 4 5 6\n"),
        bmp(2, kHeight, 8, 0, palette, bmp_pixels)})
    for (const ColourChannel channel : kColours)
      EXPECT_THAT(read(bytes, 2, channel).image.data, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(read(tiff(2, "r", {.bits = 16, .photometric = 1}), 2, ColourChannel::blue).image.data,
              ElementsAre(0x1100, 0x1101, 0x1102, 0x1103, 0x1104, 0x1105));
  expect_refused(png_bytes({2, kHeight, 8, 4}, six + six),
                 "has an alpha channel, a plain gray image is needed");
}

TEST_F(ColourChannelFiles, CheckedLikeRead) {
  const fs::path file = folder_.write("image", png_bytes({2, kHeight, 16, 6}, rows_of(2, "rgba", 16, true)));
  EXPECT_EQ(check_gray(file, ColourChannel::green), (ImageKind{2, kHeight, 16}));
  expect_user_error(ExitCode::input, "is a colour image (RGB)", [&] { check_gray(file); });
}

}  // namespace
}  // namespace fringetwin::testing::colour_channel_test
