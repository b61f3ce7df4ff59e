// SPDX-License-Identifier: Apache-2.0
#include "cli/manual/command_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>

namespace fringetwin::cli {
namespace {

constexpr const char* kProgram = "fringetwin";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) lines.push_back(line);
  return lines;
}

/// CLI11 appends what its checks say of themselves to the name of the type: "NAME:{a,b}", "N:1 ... 10".
void take_type(const std::string& type, OptionText& text) {
  const auto colon = type.find(':');
  text.value = type.substr(0, colon);
  if (colon == std::string::npos) return;
  const std::string check = type.substr(colon + 1);
  const auto bracket = check.find(" in ["), minus = check.find(" - ");  // CLI11: "INT in [1 - 10]"
  if (bracket != std::string::npos && minus != std::string::npos && check.ends_with(']')) {
    text.range = fmt::format("{} ... {}", check.substr(bracket + 5, minus - bracket - 5),
                             check.substr(minus + 3, check.size() - minus - 4));
    return;
  }
  if (!check.starts_with('{') || !check.ends_with('}')) {
    text.range = check;
    return;
  }
  std::istringstream list(check.substr(1, check.size() - 2));
  for (std::string choice; std::getline(list, choice, ',');) text.choices.push_back(choice);
}

/// Adds the options of the app, group by group in the order in which they are defined.
void add_options(const CLI::App& app, CommandText& command) {
  for (const CLI::Option* option :
       app.get_options([](const CLI::Option* o) { return o->get_positional() && !o->get_group().empty(); }))
    command.arguments.push_back(option_text(*option));
  for (const std::string& group : app.get_groups()) {
    if (group.empty() || group == kCommonOptions) continue;
    for (const CLI::Option* option : app.get_options([&](const CLI::Option* o) {
           return o->nonpositional() && o->get_group() == group && o != app.get_help_ptr();
         }))
      command.options.push_back(option_text(*option));
  }
}

const CLI::App& program_of(const CLI::App& app) {
  return app.get_parent() != nullptr ? program_of(*app.get_parent()) : app;
}

/// Options of the program are understood behind its commands, too; its version is not asked for there.
void add_common_options(const CLI::App& app, CommandText& command) {
  if (const CLI::Option* help = app.get_help_ptr()) {
    command.options.push_back(option_text(*help));
    command.options.back().group = kCommonOptions;
  }
  const CLI::App& program = program_of(app);
  for (const CLI::Option* option : program.get_options([&](const CLI::Option* o) {
         return o->nonpositional() && o->get_group() == kCommonOptions &&
                (&program == &app || o != program.get_version_ptr());
       }))
    command.options.push_back(option_text(*option));
}

}  // namespace

OptionText option_text(const CLI::Option& option) {
  OptionText text;
  for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  text.meaning = option.get_description();
  text.group = option.get_group();
  text.required = option.get_required();
  if (option.get_type_size() == 0) return text;  // a flag
  take_type(option.get_type_name(), text);
  text.default_value = option.get_default_str();
  text.repeats = option.get_expected_max() > 1;
  return text;
}

ValueKind OptionText::kind() const {
  if (!choices.empty()) return ValueKind::choice;
  for (const char* file : {"FILE", ".toml", "GLOB", "RUN"})
    if (value.find(file) != std::string::npos) return ValueKind::file;
  if (value.find("DIR") != std::string::npos) return ValueKind::folder;
  return ValueKind::none;
}

std::string OptionText::usage() const {
  const std::string values = value + (repeats ? "..." : "");
  if (names.empty()) return required ? values : "[" + values + "]";
  return names.back() + (value.empty() ? "" : " " + values);
}

std::string OptionText::sentence() const {
  std::vector<std::string> notes;
  if (required && !names.empty()) notes.emplace_back("required");
  if (!choices.empty()) notes.push_back(fmt::format("one of {}", fmt::join(choices, ", ")));
  if (!range.empty()) notes.push_back(range);
  if (!default_value.empty()) notes.push_back("default: " + default_value);
  return notes.empty() ? meaning : fmt::format("{} ({})", meaning, fmt::join(notes, "; "));
}

std::string CommandText::usage() const {
  std::string line = kProgram;
  if (!path.empty()) line += " " + path;
  for (const OptionText& argument : arguments) line += " " + argument.usage();
  for (const OptionText& option : options)
    if (option.required) line += " " + option.usage();
  if (!commands.empty()) line += " COMMAND";
  return line + " [OPTIONS]";
}

std::string own_name(const CommandText& command) {
  return command.path.substr(command.path.rfind(' ') + 1);  // npos + 1 is 0
}

std::string command_path(const CLI::App& app) {
  if (app.get_parent() == nullptr) return "";
  const std::string above = command_path(*app.get_parent());
  return above.empty() ? app.get_name() : above + " " + app.get_name();
}

CommandText command_text(const CLI::App& app) {
  CommandText command;
  command.path = command_path(app);
  command.meaning = app.get_description();
  add_options(app, command);
  add_common_options(app, command);
  const CLI::App& program = program_of(app);
  command.exit_codes = program.get_footer();
  if (&program != &app) command.examples = lines_of(app.get_footer());
  for (const CLI::App* child : app.get_subcommands(
           [](const CLI::App* a) { return !a->get_name().empty() && !a->get_group().empty(); }))
    command.commands.push_back(command_text(*child));
  return command;
}

}  // namespace fringetwin::cli
