// SPDX-License-Identifier: Apache-2.0
#include "cli/tell/json_output.hpp"

#include <fmt/format.h>

#include "twin/base/safe_file.hpp"

namespace fringetwin::cli {

void add_json_flag(CLI::App& command, bool& json, const std::string& name) {
  command.add_flag("--json", json, "Print " + name + " on stdout, too, and no other text there");
}

bool print_json_if(bool json, const std::filesystem::path& file) {
  if (json) fmt::print("{}", read_whole_text(file, {.what = "result"}));
  return json;
}

}  // namespace fringetwin::cli
