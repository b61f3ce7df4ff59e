// SPDX-License-Identifier: Apache-2.0
// Takes the commands, arguments and options of the program out of CLI11 into plain words, from which help
// pages, man pages and completions are made.
#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fringetwin::cli {

/// What a shell can offer for a value.
enum class ValueKind { none, file /**< or a folder */, folder, choice };

/// An option, or an argument without a name.
struct OptionText {
  std::vector<std::string> names;  ///< "-q", "--quiet"; none of an argument
  std::string value;               ///< "DIR", "TWIN.toml"; empty: a flag
  std::vector<std::string> choices;
  std::string range;          ///< "0.5 ... 3"
  std::string default_value;  ///< empty: none
  std::string meaning, group;
  bool required = false;
  bool repeats = false;  ///< takes several values

  ValueKind kind() const;
  /// Returns "--out DIR", as it stands in a line of usage.
  std::string usage() const;
  /// Returns the meaning, and behind it in brackets whether it is required, what it may be, what it is by
  /// default.
  std::string sentence() const;
};

struct CommandText {
  std::string path;  ///< "import opencv"; empty: the program itself
  std::string meaning;
  std::vector<std::string> examples;  ///< command lines
  std::vector<OptionText> arguments;
  std::vector<OptionText> options;    ///< in the order of their groups; those of all commands last
  std::vector<CommandText> commands;  ///< without hidden ones
  std::string exit_codes;             ///< lines

  /// Returns "fringetwin measure TWIN.toml --captures DIR --out DIR [OPTIONS]".
  std::string usage() const;
};

/// The group of the options that every command has.
inline constexpr const char* kCommonOptions = "Common options";

/// Describes an app with its subcommands. The footer of the program has the exit codes, that of a command its
/// examples; the name of an option's type is that of its value; a check is described by its range ("1 ...
/// 10"), or by {its,choices}.
CommandText command_text(const CLI::App& app);

/// Returns the last word of a command's path: what is typed for it, "opencv".
std::string own_name(const CommandText& command);

/// Describes one option as command_text() does.
OptionText option_text(const CLI::Option& option);
/// Returns the path of an app from the program on: "import opencv".
std::string command_path(const CLI::App& app);

/// Calls `visit` with the command and all of those in it, each before those in it.
template <class Visit>
void for_each_command(const CommandText& command, const Visit& visit) {
  visit(command);
  for (const CommandText& child : command.commands) for_each_command(child, visit);
}

}  // namespace fringetwin::cli
