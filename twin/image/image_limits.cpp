// SPDX-License-Identifier: Apache-2.0
#include "twin/image/image_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>

#include "twin/base/errors.hpp"
#include "twin/base/safe_file.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

// Cameras of fringe rigs have up to 65 million pixels (9344 x 7000). Decoded and as float, 2^26 pixels of 16
// bits take 400 MB. A camera whose size the twin tells may have more.
constexpr double kMostUnaskedPixels = 1 << 26;
// As of [camera] imagersize; it bounds what OpenEXR takes per line before the first is read.
constexpr double kLongestSide = 65535;
// Gray values of 16 bits take 2 bytes a pixel, as decimal text 6, those of a colour image with alpha 8.
constexpr std::uintmax_t kMostBytesPerPixel = 8;
constexpr std::uintmax_t kMostBytesBeside = 1 << 20;  // header, thumbnail, colour profile
// 24 threads with 16 MiB each: an image of 5 million pixels with 16 bits, in a file of half its size.
constexpr std::uint64_t kDecodingMemory = 24ULL << 24;

struct Decoding {
  std::mutex mutex;
  std::condition_variable given_back;
  std::uint64_t in_use = 0;
};
Decoding& decoding() {
  static Decoding one;
  return one;
}

bool is_of(const PromisedImage& image, int width, int height) {
  return image.width == static_cast<std::uint64_t>(width) &&
         image.height == static_cast<std::uint64_t>(height);
}

bool has_right_size(const PromisedImage& image, const RightSize& right) {
  return is_of(image, right.width, right.height) ||
         (right.or_width > 0 && is_of(image, right.or_width, right.or_height));
}

bool has_swapped_sides(const PromisedImage& image, const RightSize& right) {
  return !right.hint.empty() && is_of(image, right.height, right.width);
}

}  // namespace

std::uintmax_t check_image_file(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error))
    throw UserError(ExitCode::input, file.string(), "no such image", "check the name and the folder");
  const std::uintmax_t bytes = check_readable(file, {FileKind::image, "image", ExitCode::input, ""});
  if (bytes == 0) throw UserError(ExitCode::input, file.string(), "is empty (0 bytes)", "an image is needed");
  return bytes;
}

std::uint64_t check_promise(const fs::path& file, const PromisedImage& image, std::uintmax_t file_bytes,
                            const std::optional<RightSize>& right) {
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    throw UserError(ExitCode::input, file.string(), what, hint);
  };
  const std::string size = fmt::format("{} x {} px", image.width, image.height);
  if (right && !has_right_size(image, *right))
    refuse(fmt::format("is {}, {} has {} x {}{}", size, right->of, right->width, right->height,
                       right->or_width > 0
                           ? fmt::format(", its whole sensor {} x {}", right->or_width, right->or_height)
                           : ""),
           has_swapped_sides(image, *right) ? "width and height are swapped; " + right->hint : right->hint);
  if (image.width == 0 || image.height == 0) refuse(fmt::format("is {}, it has no pixels", size), "");
  const double factor = file_limits_factor();
  const double values = static_cast<double>(image.width * image.height) * static_cast<double>(image.channels);
  const double side = static_cast<double>(std::max(image.width, image.height));
  if (!right &&
      (values > kMostUnaskedPixels * factor || side > std::min(kLongestSide * factor, 2147483647.0)))
    refuse(fmt::format("is {}{}, at most {:.0f} million pixels and {:.0f} a side are read", size,
                       image.channels > 1 ? fmt::format(" with {} channels", image.channels) : "",
                       kMostUnaskedPixels * factor / 1e6, kLongestSide * factor),
           "--limits 10 reads ten times as much");
  const std::uint64_t pixels = image.width * image.height * image.channels;
  if (static_cast<double>(file_bytes) >
      factor * static_cast<double>(kMostBytesPerPixel * pixels + kMostBytesBeside))
    refuse(fmt::format("has {} bytes, more than one image of {} can need", file_bytes, size),
           "give one image a file, without other data");
  return pixels;
}

DecodingMemory::DecodingMemory(std::uint64_t bytes) : bytes_(bytes) {
  Decoding& d = decoding();
  std::unique_lock lock(d.mutex);
  d.given_back.wait(lock, [&] { return d.in_use == 0 || d.in_use + bytes_ <= kDecodingMemory; });
  d.in_use += bytes_;
}

DecodingMemory::~DecodingMemory() {
  Decoding& d = decoding();
  {
    const std::scoped_lock lock(d.mutex);
    d.in_use -= bytes_;
  }
  d.given_back.notify_all();
}

}  // namespace fringetwin
