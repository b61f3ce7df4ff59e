// SPDX-License-Identifier: Apache-2.0
#include "cli/manual/argument_fault.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>

#include "cli/manual/command_text.hpp"
#include "twin/base/nearest_word.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::cli {
namespace {

std::string named(const CLI::App& command) {
  const std::string path = command_path(command);
  return path.empty() ? "fringetwin" : path;
}

std::string help_hint(const CLI::App& command) {
  const std::string path = command_path(command);
  return fmt::format("`fringetwin help{}{}` lists them", path.empty() ? "" : " ", path);
}

std::vector<const CLI::App*> commands_in(const CLI::App& app) {
  return app.get_subcommands(
      [](const CLI::App* a) { return !a->get_name().empty() && !a->get_group().empty(); });
}

const CLI::App* child_named(const CLI::App& app, const std::string& word) {
  for (const CLI::App* child : app.get_subcommands([](const CLI::App*) { return true; }))
    if (child->get_name() == word) return child;
  return nullptr;
}

/// What begins as the word does is nearer than what resembles it: --output means --out. `begin`: what all
/// begin with says nothing.
std::string nearest_hint(const std::string& word, const std::vector<std::string>& known,
                         const std::string& otherwise, const std::string& begin = "") {
  for (const std::string& candidate : known)
    if (candidate.size() > 3 && (word.starts_with(candidate) || candidate.starts_with(word)) &&
        word.size() > 3)
      return "did you mean \"" + candidate + "\"?";
  std::vector<std::string> names;
  for (const std::string& candidate : known)
    if (candidate.starts_with(begin)) names.push_back(candidate.substr(begin.size()));
  const std::string* close = nearest(word.substr(word.starts_with(begin) ? begin.size() : 0), names);
  return close == nullptr ? otherwise : fmt::format("did you mean \"{}{}\"?", begin, *close);
}

UserError unknown_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* child : commands_in(app)) names.push_back(child->get_name());
  const std::string above = command_path(app);
  return {ExitCode::usage, above.empty() ? word : above + " " + word, "no such command",
          nearest_hint(word, names, help_hint(app))};
}

/// The option of this name that the command understands, its own or the program's.
const CLI::Option* find_option(const CLI::App& command, const std::string& name) {
  for (const CLI::App* app = &command; app != nullptr; app = app->get_parent())
    if (const CLI::Option* option = app->get_option_no_throw(name); option && option->nonpositional())
      return option;
  return nullptr;
}

void append_option_names(const CLI::App& app, std::vector<std::string>& names) {
  for (const CLI::Option* option : app.get_options([](const CLI::Option*) { return true; }))
    for (const std::string& known : option->get_lnames()) names.push_back("--" + known);
}

void append_names_of_commands(const CLI::App& app, std::vector<std::string>& names) {
  for (const CLI::App* child : commands_in(app)) {
    append_option_names(*child, names);
    append_names_of_commands(*child, names);
  }
}

/// Before a command stands, the options of all commands are near, too: most lines begin with one.
UserError unknown_option(const CLI::App& command, const std::string& name) {
  std::vector<std::string> names;
  for (const CLI::App* app = &command; app != nullptr; app = app->get_parent())
    append_option_names(*app, names);
  const std::string where = named(command) + " " + name;
  if (!commands_in(command).empty()) {
    append_names_of_commands(command, names);
    if (std::ranges::find(names, name) != names.end())
      return {ExitCode::usage, where, "is an option of commands", "it stands behind the command's name"};
  }
  return {ExitCode::usage, where, "no such option", nearest_hint(name, names, help_hint(command), "--")};
}

/// How far the words of a command line make sense.
struct Walk {
  const CLI::App* command = nullptr;
  std::optional<UserError> fault = {};
  const CLI::Option* without_value =
      nullptr;  ///< the first option that another one follows in place of its value
};

Walk walk(const CLI::App& program, const std::vector<std::string>& arguments) {
  Walk at{&program};
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "--") break;
    const bool is_option =
        word.size() > 1 && word[0] == '-' && (word[1] == '-' || !parse_number<double>(word).has_value());
    if (is_option) {
      const std::string name = word.substr(0, word.find('='));
      const CLI::Option* option = find_option(*at.command, name);
      // "-q5" is an option with its value behind it
      if (!option && word[1] != '-') option = find_option(*at.command, word.substr(0, 2));
      if (!option) {
        at.fault = unknown_option(*at.command, name);
        return at;
      }
      const bool has_value = name.size() < word.size();
      if (has_value || option->get_items_expected_max() == 0 || i + 1 == arguments.size()) continue;
      const std::string& next = arguments[i + 1];
      const bool is_one = next.size() > 1 && next[0] == '-' && !parse_number<double>(next).has_value() &&
                          find_option(*at.command, next.substr(0, next.find('='))) != nullptr;
      if (!is_one && !next.starts_with("--"))
        ++i;
      else if (is_one && !at.without_value && option->get_expected_min() > 0)
        at.without_value = option;
    } else if (!commands_in(*at.command).empty()) {
      const CLI::App* child = child_named(*at.command, word);
      if (!child) {
        at.fault = unknown_command(*at.command, word);
        return at;
      }
      at.command = child;
    }
  }
  return at;
}

/// Takes what CLI11 says of a missing option or value apart, by the option's name at its begin.
const CLI::Option* option_at_begin(const CLI::App& command, const std::string& sentence) {
  const std::string name = sentence.substr(0, sentence.find_first_of(": "));
  for (const CLI::App* app = &command; app != nullptr; app = app->get_parent())
    for (const CLI::Option* option : app->get_options([](const CLI::Option*) { return true; }))
      if (option->get_name() == name) return option;
  return nullptr;
}

/// Returns "--out DIR", or "TWIN.toml" of an argument.
std::string shown(const CLI::Option& option) {
  const OptionText text = option_text(option);
  if (text.names.empty() || text.value.empty()) return text.names.empty() ? text.value : text.names.back();
  return text.names.back() + " " + text.value;
}

UserError without_value(const CLI::App& command, const CLI::Option& option) {
  return {ExitCode::usage, named(command), shown(option) + " has no value", ""};
}

UserError missing(const CLI::App& command, const std::string& sentence) {
  const CLI::Option* option = option_at_begin(command, sentence);
  if (option)
    return {ExitCode::usage, named(command), shown(*option) + " is missing", command_text(command).usage()};
  if (!commands_in(command).empty())
    return {ExitCode::usage, named(command), "no command given", help_hint(command)};
  return {ExitCode::usage, named(command), sentence, command_text(command).usage()};
}

/// "Could not convert: --samples = many"
UserError not_converted(const CLI::App& command, const std::string& sentence) {
  constexpr std::string_view kBegin = "Could not convert: ";
  const auto equals = sentence.find(" = ");
  if (!sentence.starts_with(kBegin) || equals == std::string::npos)
    return {ExitCode::usage, named(command), sentence, ""};
  const std::string name = sentence.substr(kBegin.size(), equals - kBegin.size());
  const std::string value = sentence.substr(equals + 3);
  const bool is_number = parse_number<double>(value).has_value();
  return {ExitCode::usage, named(command) + " " + name,
          fmt::format("\"{}\" is no {}", value, is_number ? "whole number" : "number"), ""};
}

}  // namespace

const CLI::App& find_command(const CLI::App& program, const std::vector<std::string>& words) {
  const CLI::App* command = &program;
  for (const std::string& word : words) {
    const CLI::App* child = child_named(*command, word);
    if (!child) throw unknown_command(*command, word);
    command = child;
  }
  return *command;
}

std::optional<UserError> fault_of_taken_option(const CLI::App& program,
                                               const std::vector<std::string>& arguments) {
  const Walk at = walk(program, arguments);
  if (at.fault || !at.without_value) return std::nullopt;
  return without_value(*at.command, *at.without_value);
}

UserError argument_fault(const CLI::App& program, const std::vector<std::string>& arguments,
                         const CLI::ParseError& refusal) {
  const Walk at = walk(program, arguments);
  if (at.fault) return *at.fault;
  const CLI::App& command = *at.command;
  if (at.without_value) return without_value(command, *at.without_value);
  const std::string sentence = refusal.what();
  if (dynamic_cast<const CLI::RequiredError*>(&refusal)) return missing(command, sentence);
  if (dynamic_cast<const CLI::ConversionError*>(&refusal)) return not_converted(command, sentence);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&refusal)) {
    const CLI::Option* option = option_at_begin(command, sentence);
    if (option && option->results().size() > static_cast<std::size_t>(option->get_expected_max()))
      return {ExitCode::usage, named(command),
              fmt::format("{} has {} values, at most {}", shown(*option), option->results().size(),
                          option->get_expected_max()),
              ""};
    if (option) return without_value(command, *option);
  }
  if (dynamic_cast<const CLI::ExtrasError*>(&refusal)) {
    const std::vector<std::string> extra = program.remaining(true);
    return {
        ExitCode::usage, named(command),
        fmt::format("\"{}\" {} too many", fmt::join(extra, " "),
                    extra.size() == 1 ? "is one argument" : fmt::format("are {} arguments", extra.size())),
        command_text(command).usage()};
  }
  return {ExitCode::usage, named(command), sentence, ""};
}

}  // namespace fringetwin::cli
