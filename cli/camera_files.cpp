// SPDX-License-Identifier: Apache-2.0
#include "cli/camera_files.hpp"

#include <fmt/format.h>
#include <glob.h>

#include "twin/base/errors.hpp"

namespace fringetwin::cli {

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
