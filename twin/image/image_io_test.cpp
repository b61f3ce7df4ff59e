// SPDX-License-Identifier: Apache-2.0
// Images on disk.
//
// | check                          | tolerance | origin                                              |
// |--------------------------------|-----------|-----------------------------------------------------|
// | PNG, BMP, TIFF, PGM, EXR values | exact     | integers < 2^24 and float32 are stored as they are   |
// | 24 images 1440x1080            | 3 s       | 24 x 26 ms measured; the rest is for a loaded machine |
//
// Independent truth: OpenCV's codecs, and PNG files put together byte by byte in this file.
#include "twin/image/image_io.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <thread>

#include "twin/base/errors.hpp"

namespace fringetwin::image_io_test {
namespace {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ImageIo : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / fmt::format("fringetwin_image_io_{}_{}", info->name(), ::getpid());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  template <class F>
  static std::string input_error(F&& f) {
    try {
      f();
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input);
      return e.what();
    }
    ADD_FAILURE() << "no UserError was thrown";
    return "";
  }
  std::string gray_error(const fs::path& file) const {
    return input_error([&] { read_gray(file); });
  }

  fs::path folder_;
};

ImageF noise_image(int width, int height, int max_value, unsigned seed) {
  std::mt19937 generator(seed);
  ImageF image(width, height);
  for (float& v : image.data) v = static_cast<float>(generator() % static_cast<unsigned>(max_value + 1));
  image.data.front() = 0.0f;
  image.data.back() = static_cast<float>(max_value);
  return image;
}

void truncate_to(const fs::path& file, double part) {
  fs::resize_file(file, static_cast<std::uintmax_t>(static_cast<double>(fs::file_size(file)) * part));
}

// --- a PNG writer of its own: stored (uncompressed) deflate blocks, any colour type ---
void put_u32(std::string& s, std::uint32_t v) {
  for (int shift = 24; shift >= 0; shift -= 8) s.push_back(static_cast<char>((v >> shift) & 0xff));
}
std::uint32_t crc32_of(const std::string& s) {
  std::uint32_t crc = 0xffffffffu;
  for (const char c : s) {
    crc ^= static_cast<unsigned char>(c);
    for (int k = 0; k < 8; ++k) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}
void put_chunk(std::string& png, const std::string& type, const std::string& data) {
  put_u32(png, static_cast<std::uint32_t>(data.size()));
  png += type + data;
  put_u32(png, crc32_of(type + data));
}
std::string zlib_stored(const std::string& raw) {
  std::string z("\x78\x01\x01", 3);
  const auto n = static_cast<unsigned>(raw.size());
  for (const unsigned v : {n & 0xff, n >> 8, ~n & 0xff, (~n >> 8) & 0xff}) z.push_back(static_cast<char>(v));
  z += raw;
  std::uint32_t a = 1, b = 0;
  for (const char c : raw) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  put_u32(z, (b << 16) | a);
  return z;
}
/// `scanlines` without filter bytes; `row_bytes` each.
void write_raw_png(const fs::path& file, int width, int height, int bits, int color_type,
                   const std::string& scanlines, const std::string& palette = "") {
  std::string header;
  put_u32(header, static_cast<std::uint32_t>(width));
  put_u32(header, static_cast<std::uint32_t>(height));
  header += {static_cast<char>(bits), static_cast<char>(color_type), 0, 0, 0};
  std::string raw;
  const std::size_t row_bytes = scanlines.size() / static_cast<std::size_t>(height);
  for (int y = 0; y < height; ++y) {
    raw.push_back('\0');
    raw.append(scanlines, static_cast<std::size_t>(y) * row_bytes, row_bytes);
  }
  std::string png("\x89PNG\r\n\x1a\n", 8);
  put_chunk(png, "IHDR", header);
  if (!palette.empty()) put_chunk(png, "PLTE", palette);
  put_chunk(png, "IDAT", zlib_stored(raw));
  put_chunk(png, "IEND", "");
  std::ofstream(file, std::ios::binary) << png;
}

TEST_F(ImageIo, PngRoundTripIsExactFor8And16Bit) {
  for (const int bits : {8, 16}) {
    const ImageF image = noise_image(37, 23, (1 << bits) - 1, 5);
    const fs::path file = folder_ / fmt::format("sub/dir/{}.png", bits);  // folders are made
    write_gray_png(file, image, bits);
    const LoadedGray loaded = read_gray(file);
    EXPECT_EQ(loaded.file_bits, bits);
    EXPECT_EQ(loaded.image.width, 37);
    EXPECT_EQ(loaded.image.height, 23);
    EXPECT_EQ(loaded.image.data, image.data);
  }
}

TEST_F(ImageIo, OpenCvReadsOurPng) {
  for (const int bits : {8, 16}) {
    const ImageF image = noise_image(640, 48, (1 << bits) - 1, 6);
    const fs::path file = folder_ / "a.png";
    write_gray_png(file, image, bits);
    const cv::Mat mat = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(mat.type(), bits == 8 ? CV_8UC1 : CV_16UC1);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 640; ++x) {
        const int value = bits == 8 ? mat.at<std::uint8_t>(y, x) : mat.at<std::uint16_t>(y, x);
        ASSERT_EQ(static_cast<float>(value), image(x, y));
      }
  }
}

TEST_F(ImageIo, ReadsOpenCvFilesOfEveryKind) {
  for (const int depth : {CV_8U, CV_16U})
    for (const std::string extension : {"png", "bmp", "tif", "pgm"}) {
      if (depth == CV_16U && extension == "bmp") continue;
      cv::Mat mat(31, 45, depth);
      cv::theRNG().state = 7;
      cv::randu(mat, 0, depth == CV_8U ? 256 : 65536);
      const fs::path file = folder_ / ("a." + extension);
      ASSERT_TRUE(cv::imwrite(file.string(), mat));
      const LoadedGray loaded = read_gray(file);
      EXPECT_EQ(loaded.file_bits, depth == CV_8U ? 8 : 16) << extension;
      cv::Mat as_float;
      mat.convertTo(as_float, CV_32F);
      const cv::Mat ours(31, 45, CV_32F, const_cast<float*>(loaded.image.data.data()));
      EXPECT_EQ(cv::norm(as_float, ours, cv::NORM_INF), 0.0) << extension;
    }
}

TEST_F(ImageIo, LowBitDepthsKeepTheirStoredValues) {
  const fs::path file = folder_ / "bits.png";
  write_raw_png(file, 5, 2, 1, 0, std::string("\xa8\x50", 2));  // 10101, 01010
  EXPECT_THAT(read_gray(file).image.data, ::testing::ElementsAre(1, 0, 1, 0, 1, 0, 1, 0, 1, 0));
  write_raw_png(file, 3, 1, 2, 0, std::string("\x6c", 1));  // 01 10 11
  EXPECT_THAT(read_gray(file).image.data, ::testing::ElementsAre(1, 2, 3));
  write_raw_png(file, 2, 1, 4, 0, std::string("\x9f", 1));
  EXPECT_THAT(read_gray(file).image.data, ::testing::ElementsAre(9, 15));
  write_raw_png(file, 2, 1, 16, 0, std::string("\x12\x34\xff\xfe", 4));
  EXPECT_THAT(read_gray(file).image.data, ::testing::ElementsAre(0x1234, 0xfffe));
}

TEST_F(ImageIo, ColourImagesAreRefused) {
  const fs::path file = folder_ / "c.png";
  write_raw_png(file, 1, 1, 8, 2, std::string("\x07\x07\x07", 3));  // equal channels, too
  EXPECT_THAT(gray_error(file), AllOf(HasSubstr(file.string()), HasSubstr("is a colour image (RGB)")));
  write_raw_png(file, 1, 1, 8, 3, std::string(1, '\0'), "abc");
  EXPECT_THAT(gray_error(file), HasSubstr("is a colour image (palette)"));
  write_raw_png(file, 1, 1, 8, 4, std::string("\x07\xff", 2));
  EXPECT_THAT(gray_error(file), HasSubstr("has an alpha channel"));
  const fs::path bmp = folder_ / "c.bmp";
  ASSERT_TRUE(cv::imwrite(bmp.string(), cv::Mat(4, 4, CV_8UC3, cv::Scalar(1, 2, 3))));
  EXPECT_THAT(gray_error(bmp), AllOf(HasSubstr(bmp.string()), HasSubstr("3 channels")));
  const fs::path tif = folder_ / "f.tif";
  ASSERT_TRUE(cv::imwrite(tif.string(), cv::Mat(4, 4, CV_32FC1, cv::Scalar(0.5))));
  EXPECT_THAT(gray_error(tif), HasSubstr("8 or 16 bit"));
}

TEST_F(ImageIo, MissingEmptyAndForeignFilesAreNamed) {
  EXPECT_THAT(gray_error(folder_ / "none.png"), AllOf(HasSubstr("none.png"), HasSubstr("no such image")));
  EXPECT_THAT(gray_error(folder_), HasSubstr("is a folder"));
  std::ofstream(folder_ / "empty.png");
  EXPECT_THAT(gray_error(folder_ / "empty.png"), HasSubstr("is empty"));
  std::ofstream(folder_ / "text.png") << "this is no image at all";
  EXPECT_THAT(gray_error(folder_ / "text.png"), HasSubstr("no image that can be decoded"));
}

TEST_F(ImageIo, EveryTruncationOfAPngIsFound) {
  const fs::path file = folder_ / "t.png";
  write_gray_png(file, noise_image(64, 64, 255, 8), 8);
  const auto size = fs::file_size(file);
  for (auto n = size - 1; n > 0; n -= std::min<std::uintmax_t>(n, 97)) {
    fs::resize_file(file, n);
    EXPECT_THAT(gray_error(file), HasSubstr("truncated")) << n << " of " << size << " bytes";
  }
}

TEST_F(ImageIo, OneDamagedByteOfAPngIsFound) {
  const fs::path file = folder_ / "d.png";
  write_gray_png(file, noise_image(64, 64, 255, 9), 8);
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(1000);
  const char other = static_cast<char>(~stream.peek());
  stream.seekp(1000);
  stream.put(other);
  stream.close();
  EXPECT_THAT(gray_error(file), AllOf(HasSubstr("d.png"), HasSubstr("is damaged")));
}

TEST_F(ImageIo, TruncatedBmpTifPgmAreFound) {
  for (const std::string extension : {"bmp", "tif", "pgm"})
    for (const double part : {0.02, 0.5, 0.97}) {
      cv::Mat mat(64, 64, CV_8U);
      cv::randu(mat, 0, 256);
      const fs::path file = folder_ / ("t." + extension);
      ASSERT_TRUE(cv::imwrite(file.string(), mat));
      truncate_to(file, part);
      EXPECT_THAT(gray_error(file), HasSubstr("truncated")) << extension << " " << part;
    }
}

TEST_F(ImageIo, ValuesOutsideTheFormatAreAProgrammingFault) {
  ImageF image(2, 2);
  image(1, 1) = 256.0f;
  EXPECT_ANY_THROW(write_gray_png(folder_ / "x.png", image, 8));
  image(1, 1) = -1.0f;
  EXPECT_ANY_THROW(write_gray_png(folder_ / "x.png", image, 8));
  image(1, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_ANY_THROW(write_gray_png(folder_ / "x.png", image, 16));
  EXPECT_TRUE(fs::is_empty(folder_)) << "a failed write leaves nothing behind";
}

TEST_F(ImageIo, ManyThreadsWriteAtOnce) {
  constexpr int images = 8;
  ImageF image(720, 540);
  std::mt19937 generator(3);
  std::normal_distribution<float> noise(0.0f, 1.5f);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      image(x, y) = 120.0f + 90.0f * std::cos(0.3f * static_cast<float>(x)) + noise(generator);
  std::array<std::thread, 4> threads;
  for (std::size_t t = 0; t < threads.size(); ++t)
    threads[t] = std::thread([&, t] {
      for (std::size_t k = t; k < images; k += threads.size())
        write_gray_png(folder_ / fmt::format("{:04d}.png", k), image, 8);
    });
  for (auto& thread : threads) thread.join();
  for (int k = 0; k < images; ++k) {
    const LoadedGray loaded = read_gray(folder_ / fmt::format("{:04d}.png", k));
    ASSERT_EQ(loaded.image(700, 500), std::nearbyint(image(700, 500)));
  }
}

TEST_F(ImageIo, ExrKeepsNamesAndEveryBit) {
  ImageF a(19, 7), b(19, 7);
  for (std::size_t i = 0; i < a.size(); ++i)
    a.data[i] = std::exp2(static_cast<float>(i) - 60.0f) * 1.2345678f;
  b.data[3] = std::numeric_limits<float>::quiet_NaN();
  b.data[4] = std::numeric_limits<float>::infinity();
  const fs::path file = folder_ / "sub" / "phase.exr";
  write_exr(file, {{"wrapped_x_13p5", &a}, {"column_px", &b}});
  const auto channels = read_exr(file);
  ASSERT_EQ(channels.size(), 2u);  // sorted by name
  EXPECT_EQ(channels[0].first, "column_px");
  EXPECT_EQ(channels[1].first, "wrapped_x_13p5");
  EXPECT_EQ(channels[1].second.data, a.data);
  EXPECT_EQ(channels[1].second.width, 19);
  EXPECT_TRUE(std::isnan(channels[0].second.data[3]));
  EXPECT_TRUE(std::isinf(channels[0].second.data[4]));
  EXPECT_EQ(channels[0].second.data[5], 0.0f);
}

// OpenEXR reads it: blocks that pack to nothing and blocks that do not pack at all (of random bits, which are
// NaN of every kind, too), a last block of fewer lines, one pixel, and a name that needs a flag of the file.
TEST_F(ImageIo, ExrBlocksOfEveryKindKeepEveryBit) {
  std::mt19937 random(5);
  const fs::path file = folder_ / "a.exr";
  const std::string long_name = "wrapped_x_" + std::string(60, '3');
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{3, 16}, std::pair{33, 17}, std::pair{200, 50}}) {
    ImageF noise(width, height), empty(width, height, std::numeric_limits<float>::quiet_NaN());
    for (float& v : noise.data) v = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    write_exr(file, {{long_name, &noise}, {"amplitude_dn", &empty}, {"Y", &noise}});
    const auto channels = read_exr(file);
    ASSERT_EQ(channels.size(), 3U);
    const std::vector<NamedChannel> wanted = {{"Y", &noise}, {"amplitude_dn", &empty}, {long_name, &noise}};
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(channels[c].first, wanted[c].first);
      const ImageF &read = channels[c].second, &written = *wanted[c].second;
      ASSERT_TRUE(read.same_size(written));
      EXPECT_EQ(std::memcmp(read.data.data(), written.data.data(), sizeof(float) * read.size()), 0)
          << width << " x " << height << ", " << wanted[c].first;
    }
  }
}

TEST_F(ImageIo, EveryTruncationOfAnExrIsFound) {
  const ImageF image = noise_image(64, 64, 65535, 10);
  const fs::path file = folder_ / "t.exr";
  write_exr(file, {{"Y", &image}});
  const auto size = fs::file_size(file);
  for (auto n = size - 1; n > 0; n -= std::min<std::uintmax_t>(n, 997)) {
    fs::resize_file(file, n);
    EXPECT_THAT(input_error([&] { read_exr(file); }), HasSubstr("truncated")) << n << " of " << size;
  }
}

TEST_F(ImageIo, MissingAndForeignExrAreNamed) {
  EXPECT_THAT(input_error([&] { read_exr(folder_ / "no.exr"); }), HasSubstr("no such image"));
  std::ofstream(folder_ / "text.exr") << "this is no image at all";
  EXPECT_THAT(input_error([&] { read_exr(folder_ / "text.exr"); }),
              AllOf(HasSubstr("text.exr"), HasSubstr("is no EXR")));
}

TEST_F(ImageIo, TemporaryFileVanishesUnlessCommitted) {
  const fs::path file = folder_ / "a.txt";
  {
    TemporaryFile temporary(file);
    std::ofstream(temporary.path()) << "half";
    EXPECT_EQ(temporary.path().parent_path(), folder_);
  }
  EXPECT_TRUE(fs::is_empty(folder_));
  write_text_file(file, "one\n");
  write_text_file(file, "two\n");
  std::ifstream stream(file);
  std::string text;
  std::getline(stream, text);
  EXPECT_EQ(text, "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

// Where the last byte finds no room: the libraries write it when they close, and some say nothing then.
TEST_F(ImageIo, AFullDiskLeavesNoFile) {
  ImageF image(64, 50);  // OpenEXR keeps the last lines, fewer than its 16, until it closes
  std::mt19937 random(3);
  for (float& v : image.data) v = static_cast<float>(random());
  const fs::path file = folder_ / "a.exr";
  write_exr(file, {{"x", &image}});
  const std::uintmax_t size = fs::file_size(file);
  fs::remove(file);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  const rlimit less{size - 1, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &less);
  EXPECT_THROW(write_exr(file, {{"x", &image}}), UserError);
  EXPECT_THROW(write_text_file(folder_ / "b.txt", std::string(size, 'x')), UserError);
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  EXPECT_TRUE(fs::is_empty(folder_));
}

// Two processes that begin with the same name would remove each other's file.
TEST_F(ImageIo, TemporaryNamesAreOfOneProcess) {
  const auto name = [&] { return TemporaryFile(folder_ / "a").path().filename().string(); };
  const auto digits = [](const std::string& of) { return of.substr(3, 16); };
  const std::string first = name();
  EXPECT_THAT(first, ::testing::MatchesRegex("\\.a\\.[0-9a-f]{16}\\.[0-9]+\\.tmp"));
  EXPECT_NE(name(), first);
  EXPECT_EQ(digits(name()), digits(first));
  const pid_t child = ::fork();
  if (child == 0) {
    std::ofstream(folder_ / "childs") << name();
    ::_exit(0);
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  std::string childs;
  std::ifstream(folder_ / "childs") >> childs;
  ASSERT_GT(childs.size(), 19u);
  EXPECT_NE(digits(childs), digits(first));
}

TEST_F(ImageIo, UnwritableFolderIsAUsageError) {
  std::ofstream(folder_ / "file") << "x";
  try {
    write_text_file(folder_ / "file" / "a.txt", "text");
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    EXPECT_THAT(e.what(), HasSubstr("cannot make this folder"));
  }
}

}  // namespace
}  // namespace fringetwin::image_io_test
