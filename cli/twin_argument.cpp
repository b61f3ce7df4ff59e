// SPDX-License-Identifier: Apache-2.0
#include "cli/twin_argument.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "twin/base/errors.hpp"
#include "twin/twin.hpp"

namespace fringetwin::cli {
namespace {

CLI::Option* takes_folder(CLI::Option* option) {
  const auto file_of_folder = [](std::string& text) -> std::string {
    try {
      text = twin_file_of(text).string();
    } catch (const UserError&) {  // who reads the twin says so again, after --help and what is misspelt
    }
    return "";
  };
  return option->transform(CLI::Validator(file_of_folder, ""))->type_name("TWIN.toml");
}

}  // namespace

CLI::Option* add_twin_argument(CLI::App& sub, std::string& twin, const std::string& meaning) {
  return takes_folder(sub.add_option("twin", twin, meaning + ", or the folder that holds it"));
}

CLI::Option* add_twin_option(CLI::App& sub, const std::string& name, std::string& twin,
                             const std::string& meaning) {
  return takes_folder(sub.add_option(name, twin, meaning));
}

}  // namespace fringetwin::cli
