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
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

/// The folders that this process holds. Their files stay open meanwhile: that keeps the locks.
struct HeldFolders {
  struct Folder {
    int fd = -1;
    const FoldersOfCall* call = nullptr;  ///< null: until the process ends, for all of it
  };
  std::mutex mutex;
  std::map<std::pair<dev_t, ino_t>, Folder> all;
};

HeldFolders& held_folders() {
  static HeldFolders held;
  return held;
}

thread_local const FoldersOfCall* call_of_thread = nullptr;

[[noreturn]] void refuse(const fs::path& dir, const std::string& what) {
  throw UserError(ExitCode::usage, fmt::format("--out {}", dir.string()), what,
                  "choose a folder that can be written");
}

/// Waits until this process holds the folder.
void wait_for_folder(const fs::path& dir) {
  for (bool told = false; !hold_folder(dir); told = true) {
    if (!told) warn(fmt::format("{}: another run writes into this folder; waiting for it", dir.string()));
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
  const int fd = ::open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  struct stat status {};
  if (fd < 0 || ::fstat(fd, &status) != 0) {
    if (fd >= 0) ::close(fd);
    return true;
  }
  HeldFolders& held = held_folders();
  const std::lock_guard lock(held.mutex);
  const std::pair<dev_t, ino_t> folder{status.st_dev, status.st_ino};
  if (const auto known = held.all.find(folder); known != held.all.end()) {
    ::close(fd);
    return known->second.call == nullptr || known->second.call == call_of_thread;
  }
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) {
    held.all[folder] = {fd, call_of_thread};
    return true;
  }
  const bool is_others = errno == EWOULDBLOCK;
  ::close(fd);
  return !is_others;
}

FoldersOfCall::FoldersOfCall() {
  if (!call_of_thread) call_of_thread = this;
}

FoldersOfCall::~FoldersOfCall() {
  if (call_of_thread != this) return;
  call_of_thread = nullptr;
  HeldFolders& held = held_folders();
  const std::lock_guard lock(held.mutex);
  std::erase_if(held.all, [&](const auto& entry) {
    const HeldFolders::Folder& folder = entry.second;
    if (folder.call != this) return false;
    ::flock(folder.fd, LOCK_UN);  // for a child of this process, too, which has the file open
    ::close(folder.fd);
    return true;
  });
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
