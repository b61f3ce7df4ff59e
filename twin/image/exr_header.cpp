// SPDX-License-Identifier: Apache-2.0
#include "twin/image/exr_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "twin/base/errors.hpp"

namespace fringetwin {
namespace {

// Names of 1000 channels take 0.3 MB at the longest, a preview of 100 x 100 pixels 40 KB.
constexpr std::size_t kMostHeaderBytes = 1 << 20;
constexpr std::size_t kLongestExrName = 255;  // OpenEXR's own limit
// OpenEXR keeps a list of all tiles and four of them, decoded.
constexpr std::uint64_t kSmallestExrTile = 16, kLargestExrTile = 1024;
constexpr std::int64_t kFarthestCorner = 1'000'000;  // of a window from (0, 0)

/// The bytes of a header, taken one after the other.
class ExrBytes {
 public:
  ExrBytes(const std::filesystem::path& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  [[noreturn]] void refuse(const std::string& what, const std::string& hint = "") const {
    throw UserError(ExitCode::input, file_.string(), what, hint);
  }
  [[noreturn]] void broken() const {
    refuse("is no EXR that can be decoded, or is truncated (its header ends too early)");
  }

  std::string_view take(std::size_t n) {
    if (n > bytes_.size()) broken();
    const std::string_view taken = bytes_.substr(0, n);
    bytes_.remove_prefix(n);
    return taken;
  }
  std::int32_t take_int() {
    std::uint32_t value = 0;
    int shift = 0;
    for (const char byte : take(4)) {
      value |= static_cast<std::uint32_t>(static_cast<unsigned char>(byte)) << shift;
      shift += 8;
    }
    return static_cast<std::int32_t>(value);
  }
  /// Takes the text before the next NUL, and the NUL.
  std::string_view take_name() {
    const auto end = bytes_.substr(0, kLongestExrName + 1).find('\0');
    if (end == std::string_view::npos) broken();
    const std::string_view name = take(end);
    take(1);
    return name;
  }
  bool empty() const { return bytes_.empty(); }
  ExrBytes part(std::size_t n) { return {file_, take(n)}; }

 private:
  const std::filesystem::path& file_;
  std::string_view bytes_;
};

/// What the attributes say, the last of a name where it is there twice, as OpenEXR takes it; but of channels
/// it keeps those of all lists.
struct ExrAttributes {
  std::optional<std::array<std::int64_t, 4>> data_window, display_window;  ///< xMin yMin xMax yMax
  std::uint64_t channels = 0;
  std::uint64_t tile_width = 0, tile_height = 0;  ///< 0: lines
  bool levels = false;                            ///< several resolutions
};

std::array<std::int64_t, 4> take_window(ExrBytes bytes) {
  std::array<std::int64_t, 4> window{};
  for (std::int64_t& side : window) side = bytes.take_int();
  for (const std::int64_t side : window)
    if (side < -kFarthestCorner || side > kFarthestCorner)
      bytes.refuse(fmt::format("is an EXR with a window that reaches to {} px", side));
  return window;
}

std::uint64_t count_channels(ExrBytes& bytes) {
  for (std::uint64_t n = 0;; ++n) {
    const std::string_view name = bytes.take_name();
    if (name.empty()) return n;
    bytes.take(8);  // kind of number, a flag, three bytes without meaning
    const std::int32_t x_sampling = bytes.take_int(), y_sampling = bytes.take_int();
    if (x_sampling != 1 || y_sampling != 1)
      bytes.refuse(fmt::format("channel {} is subsampled, full resolution is needed", name));
  }
}

[[noreturn]] void refuse_deep(const ExrBytes& header) {
  header.refuse("is a deep EXR, a flat one is needed");
}

/// OpenEXR reads a value by its type, whatever its size says: both must agree, or what follows is read as
/// something else here and there.
void check_value(ExrBytes value, std::string_view type, std::int32_t size) {
  static const std::map<std::string_view, std::int32_t> kSizes = {{"box2i", 16},
                                                                  {"box2f", 16},
                                                                  {"chromaticities", 32},
                                                                  {"compression", 1},
                                                                  {"deepImageState", 1},
                                                                  {"double", 8},
                                                                  {"envmap", 1},
                                                                  {"float", 4},
                                                                  {"int", 4},
                                                                  {"keycode", 28},
                                                                  {"lineOrder", 1},
                                                                  {"m33f", 36},
                                                                  {"m33d", 72},
                                                                  {"m44f", 64},
                                                                  {"m44d", 128},
                                                                  {"rational", 8},
                                                                  {"tiledesc", 9},
                                                                  {"timecode", 8},
                                                                  {"v2i", 8},
                                                                  {"v2f", 8},
                                                                  {"v2d", 16},
                                                                  {"v3i", 12},
                                                                  {"v3f", 12},
                                                                  {"v3d", 24}};
  bool agrees = type != "idmanifest";  // which unpacks to any size
  if (const auto known = kSizes.find(type); known != kSizes.end()) {
    agrees = size == known->second;
  } else if (type == "chlist") {
    count_channels(value);
    agrees = value.empty();
  } else if (type == "preview") {
    const std::int64_t width = value.take_int(), height = value.take_int();
    agrees = width >= 0 && height >= 0 && width <= size && height <= size && 8 + 4 * width * height == size;
  } else if (type == "stringvector") {
    while (!value.empty()) value.take(static_cast<std::uint32_t>(value.take_int()));
  }
  if (!agrees) value.refuse(fmt::format("is an EXR with a value of type {} in {} bytes", type, size));
}

void take_attribute(ExrBytes& header, std::string_view name, ExrAttributes* out) {
  const std::string_view type = header.take_name();
  const std::int32_t size = header.take_int();
  if (size < 0) header.broken();
  ExrBytes value = header.part(static_cast<std::size_t>(size));
  check_value(value, type, size);
  if (name == "channels") {
    out->channels += count_channels(value);
  } else if (name == "dataWindow") {
    out->data_window = take_window(value);
  } else if (name == "displayWindow") {
    out->display_window = take_window(value);
  } else if (name == "type" && type == "string" && value.take(std::min(size, 4)) == "deep") {
    refuse_deep(header);
  } else if (name == "tiles") {
    out->tile_width = static_cast<std::uint32_t>(value.take_int());
    out->tile_height = static_cast<std::uint32_t>(value.take_int());
    out->levels = (value.take(1).front() & 0x0f) != 0;
  }
}

std::string head_of(const std::filesystem::path& file) {
  std::string bytes(kMostHeaderBytes, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return bytes;
}

void check_tiles(const ExrBytes& header, const ExrAttributes& found, std::uint64_t width,
                 std::uint64_t height) {
  if (found.levels) header.refuse("is an EXR of several resolutions, one is read", "save it without mipmaps");
  for (const auto& [tile, side] : {std::pair{found.tile_width, width}, {found.tile_height, height}})
    if (tile < std::min(kSmallestExrTile, side) || tile > kLargestExrTile)
      header.refuse(fmt::format("is an EXR in tiles of {} x {} px, tiles of {} to {} a side are read",
                                found.tile_width, found.tile_height, kSmallestExrTile, kLargestExrTile),
                    "save it in lines");
}

}  // namespace

PromisedImage read_exr_header(const std::filesystem::path& file) {
  const std::string bytes = head_of(file);
  ExrBytes header(file, bytes);
  if (!bytes.starts_with("\x76\x2f\x31\x01")) header.refuse("is no EXR that can be decoded, or is truncated");
  header.take(4);
  const auto flags = static_cast<std::uint32_t>(header.take_int());
  if ((flags & 0x1000U) != 0) header.refuse("is an EXR of several parts, one part is read");
  if ((flags & 0x800U) != 0) refuse_deep(header);
  ExrAttributes found;
  for (std::string_view name = header.take_name(); !name.empty(); name = header.take_name())
    take_attribute(header, name, &found);
  if (!found.data_window || found.data_window != found.display_window)
    header.refuse("is an EXR whose data window is not its display window", "save it uncropped");
  if (found.channels == 0) header.refuse("is an EXR without channels");
  const auto [x_min, y_min, x_max, y_max] = *found.data_window;
  if (x_max < x_min || y_max < y_min) header.refuse("is an EXR without pixels");
  const auto width = static_cast<std::uint64_t>(x_max - x_min + 1);
  const auto height = static_cast<std::uint64_t>(y_max - y_min + 1);
  if (const bool tiled = (flags & 0x200U) != 0; tiled || found.tile_width != 0)
    check_tiles(header, found, width, height);
  return {width, height, found.channels};
}

}  // namespace fringetwin
