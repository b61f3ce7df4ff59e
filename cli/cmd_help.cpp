// SPDX-License-Identifier: Apache-2.0
// help, version: what --help and --version say, as commands.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/manual/argument_fault.hpp"
#include "cli/manual/help_page.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cli {

void add_help(CLI::App& app, Invocation& invocation) {
  auto words = std::make_shared<std::vector<std::string>>();
  CLI::App* sub =
      app.add_subcommand("help", "The page of a command, as `fringetwin COMMAND --help` prints it");
  sub->add_option("command", *words, "Which command: measure, import opencv")->type_name("COMMAND");
  run_when_chosen(*sub, invocation, words, [&app](const std::vector<std::string>& command) {
    fmt::print("{}", help_page(command_text(find_command(app, command))));
    return static_cast<int>(ExitCode::ok);
  });
}

void add_version(CLI::App& app, Invocation& invocation) {
  CLI::App* sub = app.add_subcommand("version", "The version of the program");
  sub->callback([&invocation] {
    invocation.run = [] {
      fmt::print("{}\n", version_string());
      return static_cast<int>(ExitCode::ok);
    };
  });
}

}  // namespace fringetwin::cli
