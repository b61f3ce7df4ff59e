// SPDX-License-Identifier: Apache-2.0
#include "twin/file/toml_kept.hpp"

#include <fmt/format.h>

#include "twin/base/errors.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/file/toml_text.hpp"

namespace fringetwin {
namespace {

/// Writes absolute paths into a key that names a file or a list of files.
void name_absolutely(toml::table& table, const char* key, const std::filesystem::path& twin_file) {
  const auto absolute = [&](toml::node& node) {
    if (auto* name = node.as_string())
      *name = resolve_path(name->get(), std::filesystem::absolute(twin_file).parent_path(),
                           twin_file.string(), ExitCode::usage)
                  .string();
  };
  toml::node* node = table.get(key);
  if (!node) return;
  absolute(*node);
  if (auto* names = node->as_array())
    for (toml::node& name : *names) absolute(name);
}

std::string lines_of(const toml::table& table) {
  std::string out;
  for (const auto& [key, value] : table) out += fmt::format("{} = {}\n", key.str(), toml_text(value));
  return out;
}

}  // namespace

KeptTables kept_tables(const std::filesystem::path& twin_file) {
  KeptTables kept;
  toml::table document =
      parsed_toml(read_whole_text(twin_file, {.what = "TOML file", .code = ExitCode::usage}),
                  twin_file.string(), ExitCode::usage);
  if (toml::table* fringes = document["fringes"].as_table()) {
    name_absolutely(*fringes, "images", twin_file);
    kept.fringes = lines_of(*fringes);
  }
  if (const toml::node* intensity = document["projector"]["intensity"].node())
    kept.projector = fmt::format("intensity = {}\n", toml_text(*intensity));
  if (toml::array* cameras = document["camera"].as_array())
    for (toml::node& camera : *cameras) {
      toml::table* sensor = camera.as_table() ? (*camera.as_table())["sensor"].as_table() : nullptr;
      if (!sensor) continue;
      for (const char* key : {"prnu", "dsnu"}) name_absolutely(*sensor, key, twin_file);
      const std::string name = (*camera.as_table())["name"].value_or(std::string());
      kept.of_camera[name] = fmt::format("sensor = {}\n", toml_text(*sensor));
    }
  return kept;
}

}  // namespace fringetwin
