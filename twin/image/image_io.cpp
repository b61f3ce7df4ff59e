// SPDX-License-Identifier: Apache-2.0
#include "twin/image/image_io.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/png_codec.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

/// Writes all of it; returns 0, or the errno of what failed.
int write_bytes(int fd, FileBytes bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n > 0)
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    else if (n == 0 || errno != EINTR)
      return n == 0 ? EIO : errno;
  }
  return 0;
}

/// Writes the parts to a file that is not there yet; returns 0, or the errno of what failed.
int write_new_file(const fs::path& file, const std::vector<FileBytes>& parts) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) return errno;
  int error = 0;
  for (const FileBytes part : parts)
    if (error == 0) error = write_bytes(fd, part);
  // Shares and quotas may tell only now that the bytes found no room.
  if (::close(fd) != 0 && error == 0) error = errno;
  return error;
}

/// Returns 16 hexadecimal digits that no other process has: two of them in one folder must not meet, and
/// their process ids alone are no help where each machine or container counts its own.
std::string own_digits() {
  static const std::uint64_t random = [] {
    std::uint64_t drawn = 0;
    (void)!::getentropy(&drawn, sizeof drawn);
    return drawn;
  }();
  // What a process draws its children have as well.
  return fmt::format("{:016x}", random ^ static_cast<std::uint64_t>(::getpid()));
}

template <class T>
void round_to(const ImageF& image, float max_value, T* out) {
  const auto fits = [max_value](float v) { return v > -0.5f && v < max_value + 0.5f; };  // false for NaN, too
  bool all_fit = true;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const float value = image.data[i];
    all_fit = all_fit & fits(value);
    out[i] = static_cast<T>(static_cast<std::int32_t>(fits(value) ? value + 0.5f : 0.0f));
  }
  if (all_fit) return;
  for (std::size_t i = 0; i < image.size(); ++i)
    FT_CHECK(fits(image.data[i]), fmt::format("gray value {} at index {}", image.data[i], i));
}

}  // namespace

TemporaryFile::TemporaryFile(fs::path file) : file_(std::move(file)) {
  static std::atomic<unsigned> counter{0};
  std::error_code error;
  const fs::path folder = file_.parent_path();
  if (!folder.empty()) fs::create_directories(folder, error);
  if (error)
    throw UserError(ExitCode::usage, folder.string(),
                    fmt::format("cannot make this folder ({})", error.message()));
  temporary_ = folder / fmt::format(".{}.{}.{}.tmp", file_.filename().string(), own_digits(), counter++);
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  if (!done_) fs::remove(temporary_, ignored);
}

void TemporaryFile::commit() {
  std::error_code error;
  fs::rename(temporary_, file_, error);
  if (error)
    throw UserError(ExitCode::usage, file_.string(), fmt::format("cannot be written ({})", error.message()));
  done_ = true;
  say_more("wrote " + file_.string());
}

bool is_temporary_name(const std::string& name) { return name.starts_with('.') && name.ends_with(".tmp"); }

bool is_exr_name(const fs::path& file) { return lower_extension(file) == ".exr"; }

void write_whole_file(const fs::path& file, const std::vector<FileBytes>& parts) {
  TemporaryFile temporary(file);
  if (const int error = write_new_file(temporary.path(), parts); error != 0)
    throw UserError(ExitCode::usage, file.string(),
                    fmt::format("cannot be written ({})", std::strerror(error)),
                    "check the folder and the free space");
  temporary.commit();
}

void write_text_file(const fs::path& file, const std::string& text) {
  write_whole_file(file, {std::as_bytes(std::span(text))});
}

void write_gray_png(const fs::path& file, const ImageF& image, int file_bits) {
  FT_CHECK(file_bits == 8 || file_bits == 16, fmt::format("file_bits {}", file_bits));
  FT_CHECK(!image.empty(), "an empty image cannot be written");
  GrayPixels pixels{image.width, image.height, file_bits, {}};
  pixels.values.resize(image.size() * (file_bits == 16 ? 2u : 1u));
  if (file_bits == 16)
    round_to(image, 65535.0f, reinterpret_cast<std::uint16_t*>(pixels.values.data()));
  else
    round_to(image, 255.0f, pixels.values.data());
  std::vector<std::uint8_t> bytes;
  const std::string fault = encode_gray_png(pixels, &bytes);
  FT_CHECK(fault.empty(), fault);
  write_whole_file(file, {std::as_bytes(std::span(bytes))});
}

}  // namespace fringetwin
