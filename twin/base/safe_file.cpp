// SPDX-License-Identifier: Apache-2.0
#include "twin/base/safe_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <limits>

#include "twin/base/not_copyable.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

constexpr std::uintmax_t kMiB = 1024 * 1024;
constexpr std::size_t kLargestRead = 1 << 26;  // half a second of a slow disk; between them Ctrl-C is heeded
std::atomic<double> limits_factor = 1.0;

std::uintmax_t unraised_limit(FileKind kind) {
  switch (kind) {
    case FileKind::text:
      return 64 * kMiB;
    case FileKind::table:
      return 1024 * kMiB;
    case FileKind::image:
      return 1024 * kMiB;
    case FileKind::mesh:
      return 8 * 1024 * kMiB;
  }
  return 0;
}

UserError cannot_be_read(const fs::path& file, const FileUse& use, int error) {
  return {use.code, file.string(), fmt::format("the {} cannot be read ({})", use.what, std::strerror(error)),
          error == ENOENT ? use.hint : ""};
}

/// A file opened for reading, already checked against its kind.
class OpenFile : NotCopyable {
 public:
  OpenFile(const fs::path& file, const FileUse& use) : file_(file), use_(use) {
    struct stat status {};
    // Pipes and devices are not even opened: a pipe's writer would be let go, a tape would wind.
    if (::stat(file.c_str(), &status) == 0) check(status);
    // What came there since may be one: without O_NONBLOCK a pipe that nobody writes to waits for ever.
    fd_ = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
    if (fd_ < 0) throw cannot_be_read(file, use, errno);
    try {
      if (::fstat(fd_, &status) != 0) throw cannot_be_read(file, use, errno);
      check(status);
    } catch (...) {
      ::close(fd_);
      throw;
    }
  }
  ~OpenFile() { ::close(fd_); }

  std::uintmax_t size() const { return size_; }

  /// Reads the first `n` bytes, no more than there are.
  void read(char* out, std::uintmax_t n) {
    std::uintmax_t done = 0;
    while (done < n) {
      const auto wanted = static_cast<std::size_t>(std::min<std::uintmax_t>(n - done, kLargestRead));
      const ssize_t got = ::read(fd_, out + done, wanted);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) throw cannot_be_read(file_, use_, errno);
      if (got == 0)
        throw UserError(use_.code, file_.string(),
                        fmt::format("the {} became shorter while it was read", use_.what));
      done += static_cast<std::uintmax_t>(got);
      if (done < n) throw_if_cancelled();  // not for small files: what is read may end a cancelled run
    }
  }

 private:
  void check(const struct stat& status) {
    if (S_ISDIR(status.st_mode))
      throw UserError(use_.code, file_.string(),
                      fmt::format("is a folder, the {} must be a file", use_.what));
    if (!S_ISREG(status.st_mode))
      throw UserError(use_.code, file_.string(),
                      fmt::format("is a pipe or a device, the {} must be a regular file", use_.what));
    size_ = static_cast<std::uintmax_t>(status.st_size);
    if (const std::uintmax_t most = largest_file_bytes(use_.kind); size_ > most)
      throw UserError(use_.code, file_.string(),
                      fmt::format("the {} has {} bytes, at most {} are read", use_.what, size_, most),
                      "--limits 10 reads ten times as much");
  }

  const fs::path& file_;
  const FileUse& use_;
  int fd_ = -1;
  std::uintmax_t size_ = 0;
};

template <typename Bytes>
Bytes read_whole(const fs::path& file, const FileUse& use) {
  OpenFile open(file, use);
  Bytes bytes(static_cast<std::size_t>(open.size()), typename Bytes::value_type{});
  open.read(reinterpret_cast<char*>(bytes.data()), open.size());
  return bytes;
}

}  // namespace

std::uintmax_t largest_file_bytes(FileKind kind) {
  const double most = static_cast<double>(unraised_limit(kind)) * limits_factor;
  return most < 9e18 ? static_cast<std::uintmax_t>(most) : std::numeric_limits<std::uintmax_t>::max();
}

void raise_file_limits(double factor) { limits_factor = factor; }
double file_limits_factor() { return limits_factor; }

std::uintmax_t check_readable(const fs::path& file, const FileUse& use) { return OpenFile(file, use).size(); }

std::string read_whole_text(const fs::path& file, const FileUse& use) {
  return read_whole<std::string>(file, use);
}

std::string read_text_start(const fs::path& file, const FileUse& use, std::size_t most,
                            std::uintmax_t* file_bytes) {
  OpenFile open(file, use);
  *file_bytes = open.size();
  std::string bytes(static_cast<std::size_t>(std::min<std::uintmax_t>(most, open.size())), '\0');
  open.read(bytes.data(), bytes.size());
  return bytes;
}

std::vector<std::uint8_t> read_whole_bytes(const fs::path& file, const FileUse& use) {
  return read_whole<std::vector<std::uint8_t>>(file, use);
}

}  // namespace fringetwin
