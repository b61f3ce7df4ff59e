// SPDX-License-Identifier: Apache-2.0
#include "twin/base/paths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLongestName = 100;  // file names may have 255 bytes; the programs add their own part

/// ASCII only: the result must not depend on the locale or on a file system's encoding.
bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
         c == '.' || c == ' ';
}

}  // namespace

fs::path tidy_path(const fs::path& path) {
  const fs::path whole = fs::absolute(path);
  if (!is_utf8(whole.string()))
    throw UserError(ExitCode::usage, whole.string(), "is no UTF-8 text", "rename the file or folder");
  const bool climbs = std::ranges::find(whole, "..") != whole.end();
  if (!climbs) return whole.lexically_normal();
  std::error_code error;  // e.g. a loop of links: opening the file will name it
  const fs::path walked = fs::weakly_canonical(whole, error);
  return error ? whole : walked;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string lower_extension(const fs::path& file) { return lower_case(file.extension().string()); }

std::string name_fault(const std::string& name) {
  if (name.empty()) return "must not be empty";
  if (name.size() > kLongestName)
    return fmt::format("has {} characters and becomes part of file names: at most {}", name.size(),
                       kLongestName);
  const bool plain = std::ranges::all_of(name, is_name_character);
  if (!plain || name.front() == '.' || name.front() == ' ' || name.back() == ' ')
    return fmt::format("\"{}\" cannot become part of a file name", name);
  return "";
}

}  // namespace fringetwin
