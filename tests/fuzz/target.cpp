// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/target.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <typeinfo>
#include <utility>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::fuzz {
namespace fs = std::filesystem;
namespace {

fs::path& source() {
  static fs::path folder;
  return folder;
}

[[noreturn]] void found(const std::string& what) {
  fmt::print(stderr, "\nfinding: {}\n", what);
  std::fflush(stderr);
  std::abort();
}

/// The files of a folder by name, without its README.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != "README") files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

fs::path make_work_folder() {
  const fs::path memory = "/dev/shm";
  const fs::path root = ::access(memory.c_str(), W_OK) == 0 ? memory : fs::temp_directory_path();
  std::string name = (root / "fringetwin-fuzz-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    throw std::runtime_error("no folder can be made in " + root.string());
  return name;
}

/// Removes the folder when this process and those that it forks are gone, however they end. Returns the file
/// that keeps the folder alive while anyone has it open; -1 where no process can be started.
int watch_over(const fs::path& folder) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return -1;
  const pid_t watcher = ::fork();
  if (watcher == 0) {
    ::setsid();  // Ctrl-C is not for it
    ::close(ends[1]);
    char nothing = 0;
    while (::read(ends[0], &nothing, 1) < 0 && errno == EINTR) {
    }
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    ::_exit(0);
  }
  ::close(ends[0]);
  return ends[1];
}

int work_alive = -1;

fs::path& work() {
  static fs::path folder;
  return folder;
}

}  // namespace

const Target* find_target(const std::string& name) {
  const auto at = std::ranges::find_if(all_targets(), [&](const Target* t) { return t->name == name; });
  return at == all_targets().end() ? nullptr : *at;
}

void read_checked(const Target& target, const std::string& input) {
  try {
    target.read(input);
  } catch (const UserError& error) {
    if (error.code() != ExitCode::usage && error.code() != ExitCode::input)
      found(fmt::format("exit code {}: {}", static_cast<int>(error.code()), error.what()));
  } catch (const std::exception& error) {
    found(fmt::format("{}: {}", typeid(error).name(), error.what()));
  } catch (...) {
    found("something that is no exception was thrown");
  }
}

void set_source_folder(const fs::path& folder) { source() = folder; }

const fs::path& source_folder() { return source(); }

std::vector<std::string> seeds_of(const Target& target) {
  std::vector<std::string> seeds;
  const fs::path bad_files = source() / "tests" / "bad_files";
  for (const std::string& name : target.seed_files)
    if (fs::is_regular_file(bad_files / name)) seeds.push_back(get_file(bad_files / name));
  if (target.seeds)
    for (std::string& seed : target.seeds()) seeds.push_back(std::move(seed));
  if (seeds.empty()) throw std::runtime_error(std::string("no good input for ") + target.name);
  for (const std::string& name : target.seed_files)
    for (const fs::path& file : files_in(bad_files / name)) seeds.push_back(get_file(file));
  return seeds;
}

const fs::path& work_folder() {
  if (work().empty()) {
    work() = make_work_folder();
    work_alive = watch_over(work());
    for (const fs::path& file : files_in(source() / "tests" / "bad_files" / "good"))
      fs::copy_file(file, work() / file.filename());
    ::mkfifo((work() / "pipe").c_str(), 0600);  // for inputs that name files
  }
  return work();
}

void remove_work_folder() {
  std::error_code ignored;
  if (!work().empty()) fs::remove_all(work(), ignored);
  work().clear();
  ::close(std::exchange(work_alive, -1));
}

fs::path put_file(const std::string& name, const std::string& bytes) {
  const fs::path file = work_folder() / name;
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const bool whole = fd >= 0 && ::write(fd, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
  if (fd >= 0) ::close(fd);
  if (!whole) found("the fuzzer itself cannot write " + file.string());
  return file;
}

std::string get_file(const fs::path& file) { return testing::read_file(file); }

}  // namespace fringetwin::fuzz
