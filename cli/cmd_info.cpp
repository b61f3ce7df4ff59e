// SPDX-License-Identifier: Apache-2.0
// Adds the command `info`, which prints the versions of the program and of its libraries, the Vulkan devices,
// where real captures are looked for and where the data sets are, as text or JSON.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "cli/library_versions.hpp"
#include "cli/option_groups.hpp"
#include "render/base/device_info.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cli {
namespace {

int run_info(bool as_json) {
  nlohmann::ordered_json info;
  info["version"] = version_string();
  info["libraries"] = nlohmann::ordered_json::object();
  for (const auto& [name, version] : library_versions()) info["libraries"][name] = version;
  info["devices"] = nlohmann::ordered_json::array();
  for (const auto& device : render::list_devices())
    info["devices"].push_back({{"name", device.name},
                               {"driver", device.driver},
                               {"api_version", device.api_version},
                               {"kind", device.is_cpu ? "cpu" : "gpu"}});
  info["captures_root"] = captures_root().string();
  info["captures_present"] = std::filesystem::is_directory(captures_root());
  info["datasets_root"] = datasets_root().string();
  if (as_json) {
    fmt::print("{}\n", info.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    return 0;
  }
  fmt::print("fringetwin {}\n", version_string());
  fmt::print("libraries      ");
  for (const auto& [name, version] : library_versions()) fmt::print(" {} {}", name, version);
  fmt::print("\n");
  for (const auto& device : info["devices"])
    fmt::print("Vulkan device   {} ({}, {}, {})\n", device["name"].get<std::string>(),
               device["driver"].get<std::string>(), device["api_version"].get<std::string>(),
               device["kind"].get<std::string>());
  if (info["devices"].empty()) fmt::print("Vulkan device   none (install mesa-vulkan-drivers)\n");
  fmt::print("captures        {} ({})\n", plain_text(captures_root().string()),
             info["captures_present"].get<bool>() ? "present" : "absent; set FRINGETWIN_CAPTURES");
  fmt::print("data sets       {}\n",
             datasets_root().empty() ? "none beside the program" : plain_text(datasets_root().string()));
  return 0;
}

}  // namespace

void add_info(CLI::App& app, Invocation& invocation) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* sub = app.add_subcommand(
      "info", "Versions, Vulkan devices, where real captures are looked for, where the data sets are");
  begin_group(*sub, kOutput);
  sub->add_flag("--json", *as_json, "As JSON");
  run_when_chosen(*sub, invocation, as_json, run_info);
}

}  // namespace fringetwin::cli
