// SPDX-License-Identifier: Apache-2.0
// What an image file may ask for, known from its header before a pixel is decoded: its size, its bytes, and
// the memory that all threads together decode in. The limits are described in docs/FORMATS.md ("Limits").
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>

#include "twin/base/not_copyable.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {

/// Returns the size in bytes of an image file. Throws UserError(input) where there is none, and as
/// check_readable().
std::uintmax_t check_image_file(const std::filesystem::path& file);

/// What the header of an image file promises.
struct PromisedImage {
  std::uint64_t width = 0, height = 0;  ///< below 2^32 each
  std::uint64_t channels = 1;           ///< that are decoded
};

/// Returns the number of pixels, of all channels. Throws UserError(input) unless the image has the right
/// size, or is within the limits where nobody knows the right one, and `file_bytes` are no more than such an
/// image can need.
std::uint64_t check_promise(const std::filesystem::path& file, const PromisedImage& image,
                            std::uintmax_t file_bytes, const std::optional<RightSize>& right);

/// A share of the memory that all threads together may decode in. The constructor waits until so much is
/// left; an image larger than all of it waits until no other is decoded. A thread holds one share at a time.
class DecodingMemory : NotCopyable {
 public:
  explicit DecodingMemory(std::uint64_t bytes);
  ~DecodingMemory();

 private:
  std::uint64_t bytes_;
};

}  // namespace fringetwin
