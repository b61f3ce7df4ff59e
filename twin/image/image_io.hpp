// SPDX-License-Identifier: Apache-2.0
// PNG (8/16 bit gray, libpng), other rasters (OpenCV), EXR (float32 channels).
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "twin/image/image.hpp"

namespace fringetwin {

struct LoadedGray {
  ImageF image;       ///< the stored integer values
  int file_bits = 8;  ///< 8 or 16
};
/// Throws UserError(input) naming the file when missing, truncated, not gray, or undecodable.
LoadedGray read_gray(const std::filesystem::path& file);
/// Values are rounded and must lie in [0, 2^file_bits-1]. Fast compression; temporary name + rename.
void write_gray_png(const std::filesystem::path& file, const ImageF& image, int file_bits);

/// By the file's extension, in any case of letters.
bool is_exr_name(const std::filesystem::path& file);

using NamedChannel = std::pair<std::string, const ImageF*>;
/// Float32 EXR, ZIP compression; temporary name + rename.
void write_exr(const std::filesystem::path& file, const std::vector<NamedChannel>& channels);
/// All channels as float32. Throws UserError(input) when missing, truncated or not an EXR.
std::vector<std::pair<std::string, ImageF>> read_exr(const std::filesystem::path& file);

/// A path beside `file` for writing first; commit() renames over `file`, the destructor removes what
/// was not committed.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path file);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path file_, temporary_;
  bool done_ = false;
};
/// True for the names that TemporaryFile gives: what is found under such a name was never finished.
bool is_temporary_name(const std::string& name);

/// Writes text atomically (temporary name + rename).
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace fringetwin
