// SPDX-License-Identifier: Apache-2.0
#include "cli/manual/completions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

namespace fringetwin::cli {
namespace {

std::vector<std::string> names_of(const CommandText& command) {
  std::vector<std::string> names;
  for (const CommandText& child : command.commands) names.push_back(own_name(child));
  return names;
}

std::vector<std::string> option_names(const CommandText& command) {
  std::vector<std::string> names;
  for (const OptionText& option : command.options)
    names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

/// Gives arguments that name a command, of `help` and `man`, the program's commands to choose from.
void offer_commands(CommandText& command, const std::vector<std::string>& names) {
  for (OptionText& argument : command.arguments)
    if (argument.value == "COMMAND") argument.choices = names;
  for (CommandText& child : command.commands) offer_commands(child, names);
}

CommandText with_offered_commands(const CommandText& program) {
  CommandText copy = program;
  offer_commands(copy, names_of(program));
  return copy;
}

// ---- bash

/// What a value of the option may be, as an assignment to COMPREPLY.
std::string bash_reply(const OptionText& option) {
  switch (option.kind()) {
    case ValueKind::choice:
      return fmt::format("COMPREPLY=($(compgen -W '{}' -- \"$cur\"))", fmt::join(option.choices, " "));
    case ValueKind::folder:
      return "_fringetwin_files -d \"$cur\"";
    case ValueKind::file:
      return "_fringetwin_files -f \"$cur\"";
    case ValueKind::none:
      break;
  }
  return "COMPREPLY=()";
}

std::string bash_case(const CommandText& command) {
  std::string text = fmt::format("    '{}')\n      case \"$prev\" in\n", command.path);
  for (const OptionText& option : command.options)
    if (!option.value.empty())
      text += fmt::format("        {}) {}; return ;;\n", fmt::join(option.names, "|"), bash_reply(option));
  text += "      esac\n";
  std::vector<std::string> words = names_of(command);
  if (!command.arguments.empty()) {
    const OptionText& argument = command.arguments.front();
    words.insert(words.end(), argument.choices.begin(), argument.choices.end());
    if (argument.kind() == ValueKind::file) text += "      files=-f\n";
    if (argument.kind() == ValueKind::folder) text += "      files=-d\n";
  }
  text += fmt::format("      words='{}'\n", fmt::join(words, " "));
  text += fmt::format("      options='{}'\n", fmt::join(option_names(command), " "));
  return text + "      ;;\n";
}

// ---- zsh

/// Returns the text within single quotes for _arguments, where brackets and colons have a meaning.
std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      out += std::string("\\") + c;
    else
      out += c;
  }
  return out;
}

std::string zsh_action(const OptionText& option) {
  switch (option.kind()) {
    case ValueKind::choice:
      return fmt::format("({})", fmt::join(option.choices, " "));
    case ValueKind::folder:
      return "_files -/";
    case ValueKind::file:
      return "_files";
    case ValueKind::none:
      break;
  }
  return " ";
}

std::string zsh_function_name(const CommandText& command) {
  std::string name = "_fringetwin" + std::string(command.path.empty() ? "" : "_") + command.path;
  std::ranges::replace(name, ' ', '_');
  std::ranges::replace(name, '-', '_');
  return name;
}

std::string zsh_specs(const CommandText& command) {
  std::string text;
  for (const OptionText& option : command.options)
    for (const std::string& name : option.names) {
      text += fmt::format(" \\\n    '{}{}[{}]", option.repeats ? "*" : "", name, zsh_text(option.meaning));
      if (!option.value.empty()) text += fmt::format(":{}:{}", zsh_text(option.value), zsh_action(option));
      text += "'";
    }
  for (const OptionText& argument : command.arguments)
    text += fmt::format(" \\\n    '{}:{}:{}'", argument.repeats ? "*" : "", zsh_text(argument.value),
                        zsh_action(argument));
  return text;
}

std::string zsh_function(const CommandText& command) {
  std::string text = fmt::format("{}() {{\n", zsh_function_name(command));
  if (command.commands.empty()) return text + "  _arguments" + zsh_specs(command) + "\n}\n\n";
  text += "  local context state state_descr line\n  typeset -A opt_args\n  _arguments -C" +
          zsh_specs(command) + " \\\n    '1:command:->command' '*::argument:->rest'\n";
  text += "  case $state in\n    command)\n      local -a commands=(\n";
  for (const CommandText& child : command.commands)
    text += fmt::format("        '{}:{}'\n", own_name(child), zsh_text(child.meaning));
  text += "      )\n      _describe command commands ;;\n    rest)\n      case $line[1] in\n";
  for (const CommandText& child : command.commands)
    text += fmt::format("        {}) {} ;;\n", own_name(child), zsh_function_name(child));
  return text + "      esac ;;\n  esac\n}\n\n";
}

// ---- fish

std::string fish_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

/// When a line for the command holds: its words have been typed, and no command in it.
std::string fish_condition(const CommandText& command) {
  std::string text;
  std::istringstream words(command.path);
  for (std::string word; words >> word;)
    text += (text.empty() ? "" : "; and ") + std::string("__fish_seen_subcommand_from ") + word;
  if (!command.commands.empty())
    text += fmt::format("{}not __fish_seen_subcommand_from {}", text.empty() ? "" : "; and ",
                        fmt::join(names_of(command), " "));
  return text;
}

std::string fish_option(const CommandText& command, const OptionText& option) {
  std::string text = fmt::format("complete -c fringetwin -n '{}'", fish_condition(command));
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  switch (option.kind()) {
    case ValueKind::choice:
      text += fmt::format(" -x -a '{}'", fmt::join(option.choices, " "));
      break;
    case ValueKind::folder:
      text += " -x -a '(__fish_complete_directories)'";
      break;
    case ValueKind::file:
      text += " -r -F";
      break;
    case ValueKind::none:
      if (!option.value.empty()) text += " -x";
      break;
  }
  return fmt::format("{} -d '{}'\n", text, fish_text(option.meaning));
}

std::string fish_argument(const OptionText& argument) {
  if (argument.kind() == ValueKind::choice) return fmt::format("-a '{}'", fmt::join(argument.choices, " "));
  return argument.kind() == ValueKind::file ? "-F" : "-a '(__fish_complete_directories)'";
}

}  // namespace

std::string bash_completion(const CommandText& program) {
  std::string known, cases;
  for_each_command(with_offered_commands(program), [&](const CommandText& command) {
    cases += bash_case(command);
    if (command.path.empty()) return;
    std::string path = command.path;
    std::ranges::replace(path, ' ', '/');
    known += (known.empty() ? "" : "|") + path;
  });
  return fmt::format(
      R"(# bash completion of fringetwin, made by the program itself
_fringetwin_files() {{
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen "$1" -- "$2")
}}
_fringetwin() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}}
  if [[ $cur == = ]]; then
    cur=
  elif [[ $prev == = ]]; then
    prev=${{COMP_WORDS[COMP_CWORD-2]}}  # --out=DIR is three words
  fi
  local path= word words= options= files=
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "${{path:+$path/}}$word" in
      {}) path=${{path:+$path/}}$word ;;
    esac
  done
  COMPREPLY=()
  case "${{path//\// }}" in
{}  esac
  if [[ $cur == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$cur"))
  elif [[ -n $words ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$cur"))
  elif [[ -n $files ]]; then
    _fringetwin_files $files "$cur"
  fi
}}
complete -F _fringetwin fringetwin
)",
      known, cases);
}

std::string zsh_completion(const CommandText& program) {
  std::string text = "#compdef fringetwin\n# zsh completion of fringetwin, made by the program itself\n\n";
  for_each_command(with_offered_commands(program),
                   [&](const CommandText& command) { text += zsh_function(command); });
  return text + "_fringetwin \"$@\"\n";
}

std::string fish_completion(const CommandText& program) {
  std::string text =
      "# fish completion of fringetwin, made by the program itself\ncomplete -c fringetwin -f\n";
  for_each_command(with_offered_commands(program), [&](const CommandText& command) {
    for (const CommandText& child : command.commands)
      text += fmt::format("complete -c fringetwin -n '{}' -a {} -d '{}'\n", fish_condition(command),
                          own_name(child), fish_text(child.meaning));
    for (const OptionText& option : command.options) text += fish_option(command, option);
    if (!command.arguments.empty() && command.arguments.front().kind() != ValueKind::none)
      text += fmt::format("complete -c fringetwin -n '{}' {}\n", fish_condition(command),
                          fish_argument(command.arguments.front()));
  });
  return text;
}

}  // namespace fringetwin::cli
