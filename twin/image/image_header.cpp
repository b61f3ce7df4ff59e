// SPDX-License-Identifier: Apache-2.0
#include "twin/image/image_header.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

namespace fringetwin {
namespace {

constexpr std::size_t kHeadBytes = 4096;  // of PNG, BMP and PNM the header lies in these
constexpr std::uint64_t kMost32 = 0xffffffff;
constexpr std::uint64_t kLeastTile = 1 << 20;  // pixels of a tile that may be larger than its image
constexpr std::uint64_t kSmallestTile = 16;    // a side, as TIFF demands; there is a list of all tiles

using HeadBytes = std::vector<std::uint8_t>;

/// Returns up to `n` bytes at `offset`, fewer at the end of the file.
HeadBytes bytes_at(std::ifstream& stream, std::uint64_t offset, std::size_t n) {
  HeadBytes bytes(n);
  stream.clear();
  stream.seekg(static_cast<std::streamoff>(std::min<std::uint64_t>(offset, 1ULL << 62)));
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(n));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return bytes;
}

/// Returns the whole number of `n` bytes at `at`, which must be there.
std::uint64_t whole_number(const HeadBytes& bytes, std::size_t at, std::size_t n, bool big_endian) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < n; ++k)
    value |= static_cast<std::uint64_t>(bytes[at + k]) << (8 * (big_endian ? n - 1 - k : k));
  return value;
}

bool starts_with(const HeadBytes& bytes, const char* text, std::size_t n) {
  return bytes.size() >= n && std::memcmp(bytes.data(), text, n) == 0;
}

/// IHDR is the first chunk of every PNG.
std::optional<ImageHeader> png_header(const HeadBytes& head) {
  if (head.size() < 33 || std::memcmp(&head[8], "\0\0\0\x0dIHDR", 8) != 0) return {};
  const std::uint64_t colours = head[25] == 2 || head[25] == 6 ? 3 : 1;  // a palette's are looked up
  const std::uint64_t alpha = head[25] == 4 || head[25] == 6 ? 1 : 0;
  return ImageHeader{true, whole_number(head, 16, 4, true), whole_number(head, 20, 4, true),
                     head[24] == 16 ? 2 : 1, colours + alpha};
}

std::optional<ImageHeader> bmp_header(const HeadBytes& head) {
  if (head.size() < 30) return {};
  const std::uint64_t info_bytes = whole_number(head, 14, 4, false);
  const bool old = info_bytes == 12;
  if (!old && info_bytes < 36) return {};
  const auto side = [&](std::size_t k) {
    if (old) return whole_number(head, 18 + 2 * k, 2, false);
    const auto value = static_cast<std::int32_t>(whole_number(head, 18 + 4 * k, 4, false));
    return static_cast<std::uint64_t>(std::abs(static_cast<std::int64_t>(value)));  // < 0: upside down
  };
  return ImageHeader{false, side(0), side(1), 2};
}

/// Width and height as decimal text after "P5", with blanks and comments between them.
std::optional<ImageHeader> pnm_header(const HeadBytes& head) {
  std::array<std::uint64_t, 2> size{};
  std::size_t at = 2;
  for (std::uint64_t& side : size) {
    while (at < head.size() && (head[at] == '#' || std::isspace(head[at]) != 0)) {
      if (head[at] == '#')
        while (at < head.size() && head[at] != '\n' && head[at] != '\r') ++at;
      else
        ++at;
    }
    const std::size_t first = at;
    for (; at < head.size() && std::isdigit(head[at]) != 0 && side <= kMost32; ++at)
      side = 10 * side + (head[at] - std::uint64_t{'0'});
    if (at == first || at == head.size() || side > kMost32) return {};
  }
  return ImageHeader{false, size[0], size[1], 2};
}

/// The numbers of a TIFF's first directory that say how much memory it takes.
class TiffHeader {
 public:
  explicit TiffHeader(std::ifstream& stream) : stream_(stream) {}

  std::optional<ImageHeader> read(const HeadBytes& head) {
    big_endian_ = head[0] == 'M';
    const std::uint64_t version = head.size() >= 16 ? number(head, 2, 2) : 0;
    if (version != 42 && version != 43) return {};
    big_tiff_ = version == 43;
    if (!read_directory(big_tiff_ ? number(head, 8, 8) : number(head, 4, 4))) return {};
    const std::uint64_t area = width_ * height_;
    if (std::max({width_, height_, tile_width_, tile_height_}) > kMost32) return {};
    if ((tile_width_ | tile_height_) != 0 && std::min(tile_width_, tile_height_) < kSmallestTile) return {};
    if (tile_width_ * tile_height_ > std::max(area, kLeastTile)) return {};
    return ImageHeader{false, width_, height_, 2, samples_ == 0 ? 1 : samples_};
  }

 private:
  std::uint64_t number(const HeadBytes& bytes, std::size_t at, std::size_t n) const {
    return whole_number(bytes, at, n, big_endian_);
  }

  bool read_directory(std::uint64_t offset) {
    const std::size_t count_bytes = big_tiff_ ? 8 : 2, entry_bytes = big_tiff_ ? 20 : 12;
    const HeadBytes count = bytes_at(stream_, offset, count_bytes);
    if (count.size() < count_bytes) return false;
    const std::uint64_t n = number(count, 0, count_bytes);
    if (n > 0xffff) return false;
    const HeadBytes entries =
        bytes_at(stream_, offset + count_bytes, static_cast<std::size_t>(n) * entry_bytes);
    if (entries.size() < n * entry_bytes) return false;
    for (std::size_t k = 0; k < n; ++k)
      if (!take(entries, k * entry_bytes)) return false;
    return width_ != kMissing && height_ != kMissing;
  }

  /// Returns false where an entry that counts is there twice or is not one whole number.
  bool take(const HeadBytes& entries, std::size_t at) {
    std::uint64_t* value = member(number(entries, at, 2));
    if (value == nullptr) return true;
    const std::uint64_t type = number(entries, at + 2, 2);
    const std::size_t n = type == 3 ? 2 : type == 4 ? 4 : type == 16 && big_tiff_ ? 8 : 0;
    if (n == 0 || number(entries, at + 4, big_tiff_ ? 8 : 4) != 1) return false;
    if (*value != kMissing && *value != 0) return false;
    *value = number(entries, at + (big_tiff_ ? 12 : 8), n);
    return true;
  }

  std::uint64_t* member(std::uint64_t tag) {
    switch (tag) {
      case 256:
        return &width_;
      case 257:
        return &height_;
      case 277:
        return &samples_;
      case 322:
        return &tile_width_;
      case 323:
        return &tile_height_;
      default:
        return nullptr;
    }
  }

  static constexpr std::uint64_t kMissing = ~0ULL;
  std::ifstream& stream_;
  bool big_endian_ = false, big_tiff_ = false;
  std::uint64_t width_ = kMissing, height_ = kMissing, tile_width_ = 0, tile_height_ = 0;
  std::uint64_t samples_ = 0;  // a pixel
};

}  // namespace

std::optional<ImageHeader> read_image_header(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const HeadBytes head = bytes_at(stream, 0, kHeadBytes);
  if (starts_with(head, "\x89PNG\r\n\x1a\n", 8)) return png_header(head);
  if (starts_with(head, "BM", 2)) return bmp_header(head);
  if (starts_with(head, "II", 2) || starts_with(head, "MM", 2)) return TiffHeader(stream).read(head);
  if (head.size() > 3 && head[0] == 'P' && head[1] >= '1' && head[1] <= '6' && std::isspace(head[2]) != 0)
    return pnm_header(head);
  return {};
}

}  // namespace fringetwin
