// SPDX-License-Identifier: Apache-2.0
#include "cli/option_values.hpp"

#include <fmt/format.h>
#include <glob.h>

#include <sstream>

#include "twin/base/errors.hpp"

namespace fringetwin::cli {

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> out;
  std::stringstream list(text);
  for (std::string item; std::getline(list, item, ',');) out.push_back(item);
  return out;
}

std::optional<std::array<int, 2>> parse_size(const std::string& text) {
  std::array<int, 2> size{};
  char by = 0;
  std::stringstream in(text);
  if (!(in >> size[0] >> by >> size[1]) || by != 'x' || in.peek() != EOF) return std::nullopt;
  return size;
}

std::vector<std::filesystem::path> glob_files(const std::string& pattern) {
  glob_t found = {};
  std::vector<std::filesystem::path> files;
  if (glob(pattern.c_str(), 0, nullptr, &found) == 0)
    for (std::size_t i = 0; i < found.gl_pathc; ++i) files.emplace_back(found.gl_pathv[i]);
  globfree(&found);
  return files;
}

CameraArgument parse_camera_argument(const Twin& twin, const std::string& option, const std::string& text) {
  for (std::size_t c = 0; c < twin.cameras.size(); ++c)
    if (text.starts_with(twin.cameras[c].name + "="))
      return {c, text.substr(twin.cameras[c].name.size() + 1)};
  if (twin.cameras.size() > 1)
    throw UserError(ExitCode::usage, option + " " + text, "names no camera of the twin",
                    fmt::format("write {}={}", twin.cameras[0].name, text));
  return {0, text};
}

}  // namespace fringetwin::cli
