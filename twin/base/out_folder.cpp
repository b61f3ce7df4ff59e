// SPDX-License-Identifier: Apache-2.0
#include "twin/base/out_folder.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void refuse(const fs::path& dir, const std::string& what) {
  throw UserError(ExitCode::usage, fmt::format("--out {}", dir.string()), what,
                  "choose a folder that can be written");
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

void begin_output(const fs::path& dir, const std::vector<std::string>& last_files) {
  std::error_code error;
  fs::create_directories(dir, error);
  if (error) refuse(dir, fmt::format("cannot be made ({})", error.message()));
  for (const std::string& name : last_files) {
    fs::remove(dir / name, error);
    if (error) refuse(dir, fmt::format("{} cannot be replaced ({})", name, error.message()));
  }
}

}  // namespace fringetwin
