// SPDX-License-Identifier: Apache-2.0
#include "twin/base/out_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void refuse(const fs::path& dir, const std::string& what) {
  throw UserError(ExitCode::usage, fmt::format("--out {}", dir.string()), what,
                  "choose a folder that can be written");
}

/// Waits until this process holds the folder.
void wait_for_folder(const fs::path& dir) {
  for (bool told = false; !hold_folder(dir); told = true) {
    if (!told) warn(fmt::format("{}: another process writes into this folder; waiting for it", dir.string()));
    throw_if_cancelled();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace

void check_out_folder(const fs::path& dir) {
  if (dir.empty()) throw UserError(ExitCode::usage, "--out", "is empty", "name a folder");
  std::error_code error;
  fs::path existing = tidy_path(dir);
  while (!fs::exists(existing, error) && existing.has_relative_path()) existing = existing.parent_path();
  if (!fs::is_directory(existing, error)) refuse(dir, fmt::format("{} is no folder", existing.string()));
  if (::access(existing.c_str(), W_OK | X_OK) != 0)
    refuse(dir, fmt::format("{} cannot be written ({})", existing.string(), std::strerror(errno)));
}

bool hold_folder(const fs::path& dir) {
  static std::mutex mutex;
  static std::set<std::pair<dev_t, ino_t>> held;  // and open until the process ends: that keeps the locks
  const int fd = ::open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  struct stat status {};
  if (fd < 0 || ::fstat(fd, &status) != 0) {
    if (fd >= 0) ::close(fd);
    return true;
  }
  const std::lock_guard lock(mutex);
  const bool is_ours = held.contains({status.st_dev, status.st_ino});
  const bool locked = !is_ours && ::flock(fd, LOCK_EX | LOCK_NB) == 0;
  const bool is_others = !is_ours && !locked && errno == EWOULDBLOCK;
  if (locked)
    held.emplace(status.st_dev, status.st_ino);
  else
    ::close(fd);
  return !is_others;
}

void begin_output(const fs::path& dir, const std::vector<std::string>& last_files, Writers writers) {
  std::error_code error;
  fs::create_directories(dir, error);
  if (error) refuse(dir, fmt::format("cannot be made ({})", error.message()));
  if (writers == Writers::one) wait_for_folder(dir);
  for (const std::string& name : last_files) {
    fs::remove(dir / name, error);
    if (error) refuse(dir, fmt::format("{} cannot be replaced ({})", name, error.message()));
  }
}

}  // namespace fringetwin
