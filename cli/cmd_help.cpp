// SPDX-License-Identifier: Apache-2.0
// help, version: what --help and --version say, as commands. man, completions: the same descriptions as pages
// for man(1) and for shells; what is installed is made by them.
#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/manual/argument_fault.hpp"
#include "cli/manual/completions.hpp"
#include "cli/manual/help_page.hpp"
#include "cli/manual/man_page.hpp"
#include "cli/option_groups.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cli {
namespace {

struct ManOptions {
  std::vector<std::string> command;
  bool list = false;
};

int print_man_page(const CLI::App& app, const ManOptions& options) {
  if (options.list)
    for_each_command(command_text(app), [](const CommandText& command) {
      fmt::print("{}.1{}{}\n", man_name(command.path), command.path.empty() ? "" : " ", command.path);
    });
  else
    fmt::print("{}", man_page(command_text(find_command(app, options.command)), FRINGETWIN_VERSION));
  return static_cast<int>(ExitCode::ok);
}

int print_completions(const CLI::App& app, const std::string& shell) {
  const CommandText program = command_text(app);
  fmt::print("{}", shell == "bash"  ? bash_completion(program)
                   : shell == "zsh" ? zsh_completion(program)
                                    : fish_completion(program));
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

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

void add_man(CLI::App& app, Invocation& invocation) {
  auto options = std::make_shared<ManOptions>();
  CLI::App* sub = app.add_subcommand("man", "The page of a command for man(1), in troff");
  sub->add_option("command", options->command, "Which command: measure, import opencv")->type_name("COMMAND");
  begin_group(*sub, kOutput);
  sub->add_flag("--list", options->list, "The files of all pages, each with its command, instead");
  run_when_chosen(*sub, invocation, options,
                  [&app](const ManOptions& chosen) { return print_man_page(app, chosen); });
}

void add_completions(CLI::App& app, Invocation& invocation) {
  auto shell = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand("completions", "What a shell completes command lines with");
  sub->add_option("shell", *shell, "Whose language")
      ->type_name("SHELL")
      ->check(CLI::IsMember({"bash", "zsh", "fish"}))
      ->required();
  run_when_chosen(*sub, invocation, shell,
                  [&app](const std::string& chosen) { return print_completions(app, chosen); });
}

}  // namespace fringetwin::cli
