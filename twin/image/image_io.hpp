// SPDX-License-Identifier: Apache-2.0
// Reads gray images, and one colour of colour images (PNG of 8 or 16 bits through libpng, BMP, TIFF, PGM and
// PPM through a module), reads and writes EXR (float32 channels), and writes files under a temporary name
// first.
#pragma once
#include <compare>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "twin/base/not_copyable.hpp"
#include "twin/image/colour_channel.hpp"
#include "twin/image/image.hpp"

namespace fringetwin {

/// The size that an image must have. It is compared with the file's header, before a pixel is decoded; where
/// it is not known, images above a limit are refused (docs/FORMATS.md, "Limits").
struct RightSize {
  int width = 0, height = 0;
  std::string of = {};    ///< what has this size: `camera "left"`
  std::string hint = {};  ///< what to do about another
  /// Another size that it may have, where there is one: that of a whole colour sensor beside its channel's.
  int or_width = 0, or_height = 0;
};

struct LoadedGray {
  ImageF image;       ///< the stored integer values
  int file_bits = 8;  ///< 8 or 16
};
/// Reads a gray image, or the values of `channel` of a colour image. Throws UserError(input) naming the file
/// when missing, truncated, a colour image where no channel is given, undecodable, or of another size.
LoadedGray read_gray(const std::filesystem::path& file, const std::optional<RightSize>& right = {},
                     const std::optional<ColourChannel>& channel = {});

struct ImageKind {
  int width = 0, height = 0;
  int bits = 0;  ///< of the file's values: 8, 16; 32 for EXR
  auto operator<=>(const ImageKind&) const = default;
};
/// Decodes an image to its end, as read_gray(), and an EXR of one channel, without keeping them.
ImageKind check_gray(const std::filesystem::path& file, const std::optional<ColourChannel>& channel = {});
ImageKind check_exr(const std::filesystem::path& file);
/// Writes the values, which are rounded and must lie in [0, 2^file_bits-1]. Fast compression; temporary name
/// + rename.
void write_gray_png(const std::filesystem::path& file, const ImageF& image, int file_bits);

/// Returns whether the file's extension, in any case of letters, says EXR.
bool is_exr_name(const std::filesystem::path& file);

using NamedChannel = std::pair<std::string, const ImageF*>;
/// Writes a float32 EXR with ZIP compression, to a temporary name that is then renamed.
void write_exr(const std::filesystem::path& file, const std::vector<NamedChannel>& channels);
/// Reads all channels as float32. Throws UserError(input) when missing, truncated or not an EXR.
std::vector<std::pair<std::string, ImageF>> read_exr(const std::filesystem::path& file);
/// Reads an EXR of one channel. Throws as read_exr(), and where it has another size, more channels or values
/// that are no irradiance (NaN, infinite).
ImageF read_irradiance(const std::filesystem::path& file, const RightSize& right);

/// A path beside `file` for writing first; commit() renames over `file`, the destructor removes what
/// was not committed.
class TemporaryFile : NotCopyable {
 public:
  explicit TemporaryFile(std::filesystem::path file);
  ~TemporaryFile();
  const std::filesystem::path& path() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path file_, temporary_;
  bool done_ = false;
};
/// Returns true for the names that TemporaryFile gives: what is found under such a name was never finished.
bool is_temporary_name(const std::string& name);

using FileBytes = std::span<const std::byte>;
/// Writes the parts, one after the other, as one file: whole under its name, or not at all. Throws
/// UserError(usage).
void write_whole_file(const std::filesystem::path& file, const std::vector<FileBytes>& parts);
/// The same with text.
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace fringetwin
