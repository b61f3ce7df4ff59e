// SPDX-License-Identifier: Apache-2.0
// Image files that are wrong, or that ask for more than they should: each is refused with one sentence that
// names it, before memory is taken for what its header promises.
//
// | check                      | tolerance | origin                                                         |
// |----------------------------|-----------|----------------------------------------------------------------|
// | memory for refused images  | 100 MB    | the bombs among them promise 3.6 GB and more, the others 20 KB |
// | memory for 60 packed texts | 100 MB    | unpacked they take 470 MB                                      |
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <future>

#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/expect_user_error.hpp"
#include "tests/support/twin/png_bytes.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/image/image_io.hpp"
#include "twin/image/image_limits.hpp"

namespace fringetwin::testing::bad_image_test {
namespace {
namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

const RightSize kCamera{160, 120, "camera \"left\"", "check imagersize"};
const RightSize kProjector{64, 48, "the projector", ""};

double peak_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

fs::path bad_files() {
  const char* source = std::getenv("FRINGETWIN_SOURCE");
  return fs::path(source ? source : ".") / "tests" / "bad_files";
}

template <typename Read>
void expect_all_refused(const std::string& folder, std::size_t least, const Read& read) {
  std::size_t n = 0;
  for (const auto& entry : fs::directory_iterator(bad_files() / folder)) {
    const fs::path& file = entry.path();
    if (file.filename() == "README") continue;
    ++n;
    const double before = peak_mb();
    try {
      read(file);
      ADD_FAILURE() << file << " was read";
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::input) << error.what();
      EXPECT_THAT(error.what(), StartsWith(file.string() + ": "));
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    }
    EXPECT_LT(peak_mb() - before, 100.0) << file;
  }
  EXPECT_GE(n, least);
}

/// A black image, with `more` chunks before its pixels.
std::string png(int width, int height, const std::string& more = "") {
  const std::string rows(static_cast<std::size_t>(height) * static_cast<std::size_t>(width), '\0');
  return png_bytes({width, height, 8, 0}, rows, more);
}

TEST(BadImages, NoFileOfTheCollectionGetsThroughForAChannel) {
  const auto read = [](const fs::path& file) {
    read_gray(file, kCamera, ColourChannel::green);
    // Nothing is wrong with these but that they are coloured.
    const std::string name = file.filename().string();
    if (name == "rgb.png" || name == "palette.png" || name == "rgb.tif")
      throw UserError(ExitCode::input, file.string(), "is read");
  };
  expect_all_refused("png", 30, read);
  expect_all_refused("tiff", 30, read);
}

TEST(BadImages, ChannelsCountWhereTheyAreDecoded) {
  const ScratchFolder folder;
  const auto head = [&](int bits, int color_type) {
    return folder.write("head.png", png_bytes({8000, 6000, bits, color_type}, ""));
  };
  constexpr ColourChannel kRed = ColourChannel::red;
  expect_user_error(ExitCode::input, "is 8000 x 6000 px with 3 channels, at most 67 million pixels",
                    [&] { check_gray(head(8, 2), kRed); });
  expect_user_error(ExitCode::input, "is 8000 x 6000 px with 4 channels",
                    [&] { check_gray(head(16, 6), kRed); });
  expect_user_error(ExitCode::input, "is a colour image (RGB)", [&] { check_gray(head(8, 2)); });
  expect_user_error(ExitCode::input, "(libpng: ", [&] { check_gray(head(8, 0), kRed); });
}

TEST(BadImages, EveryCutOfAColourImageIsFound) {
  const ScratchFolder folder;
  const std::string row(3 * 160, '\x40');
  std::string rows;
  for (int k = 0; k < 120; ++k) rows += row;
  const std::string bmp_head =
      std::string("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\xa0\0\0\0\x78\0\0\0\1\0\x18\0", 30) +
      std::string(24, '\0');
  for (const std::string& whole :
       {png_bytes({160, 120, 8, 2}, rows), "P6\n160 120\n255\n" + rows, bmp_head + rows}) {
    const auto read = [&](std::size_t bytes) {
      return read_gray(folder.write("image", whole.substr(0, bytes)), kCamera, ColourChannel::blue);
    };
    EXPECT_EQ(read(whole.size()).image(159, 119), 64.0F);
    for (std::size_t bytes = whole.size() - 1; bytes > 0;
         bytes -= std::min<std::size_t>(bytes, 1 + bytes / 7))
      expect_user_error(ExitCode::input, "image: ", [&] { read(bytes); });
  }
}

TEST(BadImages, EveryFileOfTheCollectionIsRefused) {
  expect_all_refused("png", 30, [](const fs::path& file) { read_gray(file, kCamera); });
  expect_all_refused("tiff", 30, [](const fs::path& file) { read_gray(file, kCamera); });
  expect_all_refused("exr", 30, [](const fs::path& file) { read_irradiance(file, kCamera); });
  expect_all_refused("patterns", 7, [](const fs::path& file) { read_gray(file, kProjector); });
}

TEST(BadImages, TheSizeIsComparedBeforeAnythingIsDecoded) {
  const fs::path bomb = bad_files() / "png" / "bomb.png";
  expect_user_error(ExitCode::input, "is 60000 x 60000 px, camera \"left\" has 160 x 120; check imagersize",
                    [&] { read_gray(bomb, kCamera); });
  for (const char* name : {"png/bomb.png", "tiff/bomb.tif", "tiff/bomb.bmp", "tiff/bomb.pgm"})
    expect_user_error(ExitCode::input, "is 60000 x 60000 px, at most 67 million pixels and 65535 a side",
                      [&] { check_gray(bad_files() / name); });
  const RightSize upright{640, 480, "camera \"left\"", "check imagersize"};
  const ScratchFolder folder;
  const fs::path swapped = folder.write("swapped.png", png(480, 640));
  expect_user_error(ExitCode::input, "640 x 480; width and height are swapped; check imagersize",
                    [&] { read_gray(swapped, upright); });
  expect_user_error(ExitCode::input, "is 60000 x 60000 px", [&] { check_exr(bad_files() / "exr/bomb.exr"); });
}

TEST(BadImages, WhereNoSizeIsRightALimitHolds) {
  const fs::path file = "image.png";
  const auto promise = [&](std::uint64_t width, std::uint64_t height, std::uint64_t channels = 1) {
    check_promise(file, {width, height, channels}, 100, {});
  };
  EXPECT_NO_THROW(promise(9344, 7000));
  expect_user_error(ExitCode::input, "--limits 10", [&] { promise(8193, 8192); });
  expect_user_error(ExitCode::input, "65535 a side", [&] { promise(65536, 1); });
  expect_user_error(ExitCode::input, "with 1000 channels", [&] { promise(1440, 1080, 1000); });
  expect_user_error(ExitCode::input, "has no pixels", [&] { promise(0, 5); });
  raise_file_limits(10.0);
  EXPECT_NO_THROW(promise(20000, 20000));
  EXPECT_NO_THROW(promise(65536, 1));
  raise_file_limits(1.0);
}

TEST(BadImages, PipesAndDevicesAreRefusedWithoutWaiting) {
  const ScratchFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const fs::path& file : {folder / "pipe", fs::path("/dev/zero"), fs::path("/dev/null")}) {
    expect_user_error(ExitCode::input, "is a pipe or a device", [&] { read_gray(file); });
    expect_user_error(ExitCode::input, "is a pipe or a device", [&] { check_gray(file); });
    expect_user_error(ExitCode::input, "is a pipe or a device", [&] { read_irradiance(file, kCamera); });
    expect_user_error(ExitCode::input, "is a pipe or a device", [&] { read_exr(file); });
  }
}

TEST(BadImages, FilesOfMoreBytesThanTheirImageNeeds) {
  const ScratchFolder folder;
  const fs::path file = folder.write("long.png", png(20, 10));
  fs::resize_file(file, 900'000'000);  // with a gap that takes no disk
  const double before = peak_mb();
  expect_user_error(ExitCode::input, "has 900000000 bytes, more than one image of 20 x 10 px can need",
                    [&] { read_gray(file); });
  EXPECT_LT(peak_mb() - before, 100.0);
  fs::resize_file(file, 1'000'000);
  EXPECT_EQ(read_gray(file).image.width, 20);
}

TEST(BadImages, TextsOfAPngAreNotUnpacked) {
  const ScratchFolder folder;
  const std::string text =
      png_chunk("zTXt", std::string("note\0\0", 6) + packed(std::string(7'900'000, 'a')));
  std::string texts;
  for (int k = 0; k < 60; ++k) texts += text;
  const fs::path file = folder.write("texts.png", png(20, 10, texts));
  const double before = peak_mb();
  EXPECT_EQ(read_gray(file).image.width, 20);
  EXPECT_LT(peak_mb() - before, 100.0);
}

TEST(BadImages, AThousandChannelsAreNotDecodedForOne) {
  const ScratchFolder folder;
  const ImageF image(16, 12, 1.0F);
  std::vector<NamedChannel> channels;
  for (int k = 0; k < 1000; ++k) channels.emplace_back(fmt::format("c{:03d}", k), &image);
  const fs::path file = folder / "many.exr";
  write_exr(file, channels);
  const RightSize right{16, 12};
  expect_user_error(ExitCode::input, "has 1000 channels, an irradiance image has one",
                    [&] { read_irradiance(file, right); });
  EXPECT_EQ(read_exr(file).size(), 1000u);
  write_exr(file, {channels.front()});
  EXPECT_EQ(read_irradiance(file, right).data, image.data);
  EXPECT_EQ(check_exr(file), (ImageKind{16, 12, 32}));
}

TEST(BadImages, ThreadsDecodeInOneBoundedMemory) {
  constexpr std::uint64_t kMiB = 1 << 20;
  using std::chrono::milliseconds;
  const auto wants = [](std::uint64_t bytes) {
    return std::async(std::launch::async, [bytes] { const DecodingMemory memory(bytes); });
  };
  auto first = std::make_unique<DecodingMemory>(300 * kMiB);
  wants(50 * kMiB).get();
  auto second = wants(200 * kMiB), larger_than_all = wants(1000 * kMiB);
  EXPECT_EQ(second.wait_for(milliseconds(30)), std::future_status::timeout);
  EXPECT_EQ(larger_than_all.wait_for(milliseconds(30)), std::future_status::timeout);
  first.reset();
  second.get();
  larger_than_all.get();
}

/// Two rows of three gray values, 1 ... 6, uncompressed; with a directory of either layout, in a strip or in
/// a tile of 16 x 16.
std::string tiff(bool big, bool motorola, bool tiled, bool says_black = true) {
  std::string out;
  const auto put = [&](std::uint64_t value, int bytes) {
    for (int k = 0; k < bytes; ++k) out += static_cast<char>(value >> (8 * (motorola ? bytes - 1 - k : k)));
  };
  std::vector<std::pair<int, int>> tags = {{256, 3}, {257, 2}, {258, 8}, {259, 1}};
  if (says_black) tags.emplace_back(262, 1);
  if (tiled)
    tags.insert(tags.end(), {{277, 1}, {322, 16}, {323, 16}, {324, 0}, {325, 256}});
  else
    tags.insert(tags.end(), {{273, 0}, {277, 1}, {278, 2}, {279, 6}});
  const int count_bytes = big ? 8 : 2, entry_bytes = big ? 20 : 12, offset_bytes = big ? 8 : 4;
  const int head_bytes = big ? 16 : 8;
  const int data = head_bytes + count_bytes + static_cast<int>(tags.size()) * entry_bytes + offset_bytes;
  out = motorola ? "MM" : "II";
  put(big ? 43 : 42, 2);
  if (big) put(8, 2), put(0, 2);
  put(static_cast<std::uint64_t>(head_bytes), offset_bytes);
  put(tags.size(), count_bytes);
  for (const auto& [tag, value] : tags) {
    put(static_cast<std::uint64_t>(tag), 2);
    put(4, 2);  // a number of 32 bits
    put(1, offset_bytes);
    put(static_cast<std::uint64_t>(value == 0 ? data : value), 4);
    if (big) put(0, 4);
  }
  put(0, offset_bytes);
  if (!tiled) return out + "\1\2\3\4\5\6";
  std::string tile(256, '\7');
  tile.replace(0, 3, "\1\2\3").replace(16, 3, "\4\5\6");
  return out + tile;
}

TEST(BadImages, GoodFilesOfOtherLayoutsAreStillRead) {
  const ScratchFolder folder;
  const auto values = [&](const std::string& bytes) {
    return read_gray(folder.write("image", bytes), RightSize{3, 2}).image.data;
  };
  for (const bool big : {false, true})
    for (const bool motorola : {false, true})
      for (const bool tiled : {false, true})
        EXPECT_THAT(values(tiff(big, motorola, tiled)), ElementsAre(1, 2, 3, 4, 5, 6))
            << big << motorola << tiled;
  EXPECT_THAT(values(tiff(false, false, false, false)), ElementsAre(1, 2, 3, 4, 5, 6)) << "not inverted";
  EXPECT_THAT(values("P2 # by hand\n#\n3\t2 # columns, rows\n255\n1 2 3\n4 5 6\n"),
              ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(values("P5 3 2 255\n\1\2\3\4\5\6"), ElementsAre(1, 2, 3, 4, 5, 6));
}

}  // namespace
}  // namespace fringetwin::testing::bad_image_test
