// SPDX-License-Identifier: Apache-2.0
// How every reader opens a file that someone else may have written: a regular file, of a bounded size, whole
// or an error. The limits are described in docs/FORMATS.md ("Limits").
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/base/errors.hpp"

namespace fringetwin {

/// What a file is for; each kind has a largest size that is read.
enum class FileKind {
  text,   ///< twins, capture sets, studies, camera models, results: 64 MiB
  table,  ///< corners, matches, databases, journals: 1 GiB
  image,  ///< 1 GiB
  mesh,   ///< 8 GiB
};

/// Returns the number of bytes above which a file of this kind is refused.
std::uintmax_t largest_file_bytes(FileKind kind);

/// Multiplies every limit of this file by `factor` (> 0); for users who trust what they read.
void raise_file_limits(double factor);
/// Returns the factor in force, 1 unless raised.
double file_limits_factor();

/// What a sentence about a file that cannot be read says.
struct FileUse {
  FileKind kind = FileKind::text;
  std::string what = "file";  ///< "camera model", "image"
  ExitCode code = ExitCode::input;
  std::string hint = {};  ///< what to do where the file does not exist
};

/// Returns the size of `file` in bytes, for readers of other libraries that open the path themselves. Throws
/// UserError(use.code) unless it is a regular file (no folder, pipe or device) that may be read and is not
/// above its kind's limit. Never waits for a pipe.
std::uintmax_t check_readable(const std::filesystem::path& file, const FileUse& use);

/// Returns all bytes of `file`; throws as check_readable, and where a read fails or the file ends early;
/// Cancelled on the way through a file of more than 64 MiB.
std::string read_whole_text(const std::filesystem::path& file, const FileUse& use);
/// Returns the first `most` bytes of `file`, or all; its size goes to `file_bytes`.
std::string read_text_start(const std::filesystem::path& file, const FileUse& use, std::size_t most,
                            std::uintmax_t* file_bytes);
std::vector<std::uint8_t> read_whole_bytes(const std::filesystem::path& file, const FileUse& use);

}  // namespace fringetwin
