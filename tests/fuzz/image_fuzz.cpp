// SPDX-License-Identifier: Apache-2.0
// Images: PNG through libpng, other formats through the module of codecs, EXR; gray, and one colour of
// several.
#include <fmt/format.h>

#include "tests/fuzz/structured.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/support/twin/png_bytes.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::fuzz {
namespace {

constexpr int kWidth = 5, kHeight = 4;

/// Returns the bytes of an image with so many a pixel.
std::size_t pixel_bytes(int bytes) { return static_cast<std::size_t>(kWidth * kHeight * bytes); }

ImageF some_image(float step) {
  ImageF image(kWidth, kHeight);
  for (std::size_t i = 0; i < image.size(); ++i) image.data[i] = step * static_cast<float>(i);
  return image;
}

std::vector<std::string> pngs() {
  std::vector<std::string> files;
  for (const int bits : {8, 16}) {
    const auto file = work_folder() / "seed.png";
    write_gray_png(file, some_image(3.0f), bits);
    files.push_back(get_file(file));
  }
  for (const int bits : {8, 16})
    for (const int channels : {3, 4})
      files.push_back(testing::png_bytes({kWidth, kHeight, bits, channels == 3 ? 2 : 6},
                                         std::string(pixel_bytes(channels * bits / 8), 'x')));
  files.push_back(testing::png_bytes({kWidth, kHeight, 8, 3}, std::string(pixel_bytes(1), '\1'),
                                     testing::png_chunk("PLTE", "abcdef")));
  return files;
}

std::vector<std::string> exrs() {
  const ImageF a = some_image(0.25f), b = some_image(2.0f);
  std::vector<std::string> files;
  for (const auto& channels : {std::vector<NamedChannel>{{"Y", &a}}, {{"Y", &a}, {"x", &b}, {"z.z", &b}}}) {
    const auto file = work_folder() / "seed.exr";
    write_exr(file, channels);
    files.push_back(get_file(file));
  }
  return files;
}

std::string little_endian(std::uint32_t value, std::size_t bytes) {
  std::string out;
  for (std::size_t i = 0; i < bytes; ++i) out.push_back(static_cast<char>(value >> (8 * i)));
  return out;
}

std::string tiff(unsigned bits, unsigned samples = 1) {
  const std::uint32_t size = kWidth * kHeight * samples * bits / 8, data = 8 + 2 + 10 * 12 + 4;
  // tag, value; each of one number: width, height, bits, no compression, black is 0 or RGB, strips ...
  const std::pair<std::uint32_t, std::uint32_t> tags[] = {
      {256, kWidth}, {257, kHeight}, {258, bits},    {259, 1},    {262, samples == 1 ? 1 : 2},
      {273, data},   {277, samples}, {278, kHeight}, {279, size}, {339, 1}};
  std::string file = "II*" + std::string(1, '\0') + little_endian(8, 4) + little_endian(10, 2);
  for (const auto& [tag, value] : tags)
    file += little_endian(tag, 2) + little_endian(4, 2) + little_endian(1, 4) + little_endian(value, 4);
  return file + little_endian(0, 4) + std::string(size, 'x');
}

std::string bmp_of_colours(std::uint32_t bits) {
  const std::uint32_t row = (kWidth * bits / 8 + 3) / 4 * 4, head = 54;
  std::string file = "BM" + little_endian(head + row * kHeight, 4) + little_endian(0, 4) +
                     little_endian(head, 4) + little_endian(40, 4) + little_endian(kWidth, 4) +
                     little_endian(kHeight, 4) + little_endian(1, 2) + little_endian(bits, 2);
  file.resize(head, '\0');
  return file + std::string(row * kHeight, 'x');
}

std::string bmp() {
  constexpr std::uint32_t kPalette = 1024, kHead = 54, kRow = 8;  // rows are filled to four bytes
  std::string file = "BM" + little_endian(kHead + kPalette + kRow * kHeight, 4) + little_endian(0, 4) +
                     little_endian(kHead + kPalette, 4) + little_endian(40, 4) + little_endian(kWidth, 4) +
                     little_endian(kHeight, 4) + little_endian(1, 2) + little_endian(8, 2);
  file.resize(kHead, '\0');
  for (std::uint32_t gray = 0; gray < 256; ++gray) file += little_endian(gray * 0x010101, 4);
  return file + std::string(kRow * kHeight, 'x');
}

std::vector<std::string> other_images() {
  std::string plain = fmt::format("P2\n# plain\n{} {}\n255\n", kWidth, kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i) plain += fmt::format("{} ", i);
  return {tiff(8),
          tiff(16),
          tiff(8, 3),
          tiff(16, 4),
          bmp(),
          bmp_of_colours(24),
          bmp_of_colours(32),
          plain,
          fmt::format("P5\n{} {}\n255\n", kWidth, kHeight) + std::string(kWidth * kHeight, 'x'),
          fmt::format("P5\n{} {}\n65535\n", kWidth, kHeight) + std::string(2 * kWidth * kHeight, 'x'),
          fmt::format("P6\n{} {}\n255\n", kWidth, kHeight) + std::string(pixel_bytes(3), 'x'),
          fmt::format("P6\n{} {}\n4095\n", kWidth, kHeight) + std::string(pixel_bytes(6), 'x'),
          fmt::format("Pf\n{} {}\n-1.0\n", kWidth, kHeight) + std::string(4 * kWidth * kHeight, 'x')};
}

/// Every image of a capture set is this one: only one of the camera's size is read to its end.
void load_as_captures(const std::filesystem::path& file) {
  static const Twin twin = load_twin(work_folder() / "twin.toml",
                                     {{"camera.left.imagersize", fmt::format("[{}, {}]", kWidth, kHeight)},
                                      {"camera.left.intrinsics", "[9, 9, 2, 1.5, 0, 0, 0, 0]"},
                                      {"fringes.steps", "3"}});
  CaptureSet set;
  set.file = work_folder() / "capture.toml";
  set.channel = ColourChannel::green;
  set.cameras.emplace_back().name = "left";
  set.cameras.back().files.assign(expand_sequence(twin.fringes).size(), file);
  load_camera_images(set, twin.cameras.front(), twin.fringes);
}

void read_gray_image(const std::filesystem::path& file) {
  read_or_refuse([&] { read_gray(file); });
  read_or_refuse([&] { read_gray(file, {}, ColourChannel::blue); });
  load_as_captures(file);
}

void read_any_exr(const std::string& input) {
  const std::filesystem::path file = put_file("input.exr", input);
  read_or_refuse([&] { read_exr(file); });
  load_as_captures(file);
}

}  // namespace

extern const Target png_target, tiff_target, exr_target;

const Target png_target = {
    "png",      [](const std::string& input) { read_gray_image(put_file("input.png", input)); },
    {"png"},    pngs,
    mutate_png, {"IHDR", "IDAT", "IEND", "PLTE", "tRNS", "gAMA", "\x89PNG\r\n\x1a\n"}};

const Target tiff_target = {
    "tiff",
    // the first bytes choose the codec; the name only keeps the file from being EXR
    [](const std::string& input) { read_gray_image(put_file("input.tif", input)); },
    {"tiff"},
    other_images,
    nullptr,
    {"II*", "MM", "BM", "P5\n", "P2\n", "P1\n", "P6\n", "Pf\n", "\xff\xd8\xff", "RIFF", "WEBP",
     "#?RADIANCE\n", "GIF89a", "\x59\xa6\x6a\x95", "\x76\x2f\x31\x01", "jP  \r\n\x87\n"}};

const Target exr_target = {
    "exr",
    read_any_exr,
    {"exr"},
    exrs,
    nullptr,
    {"channels", "chlist", "compression", "dataWindow", "box2i", "displayWindow", "lineOrder", "tiles",
     "tiledesc", "type", "scanlineimage", "deepscanline", "chunkCount", "name", "Y"}};

}  // namespace fringetwin::fuzz
