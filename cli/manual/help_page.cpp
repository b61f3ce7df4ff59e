// SPDX-License-Identifier: Apache-2.0
#include "cli/manual/help_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <sstream>

namespace fringetwin::cli {
namespace {

constexpr std::size_t kMeaningColumn = 28;

/// Returns the words in lines of at most `width`, those behind the first one indented.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::string out;
  std::size_t column = indent;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (column > indent && column + 1 + word.size() > width) {
      out += "\n" + std::string(indent, ' ');
      column = indent;
    }
    if (column > indent) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
  }
  return out;
}

/// Returns one entry of a list: what it is called, and from a column on what it means.
std::string entry(const std::string& name, const std::string& meaning, std::size_t width) {
  std::string out = "  " + name;
  if (out.size() + 2 > kMeaningColumn)
    out += "\n" + std::string(kMeaningColumn, ' ');
  else
    out.resize(kMeaningColumn, ' ');
  return out + wrapped(meaning, width, kMeaningColumn) + "\n";
}

std::string name_of(const OptionText& option) {
  const std::string values = option.value + (option.repeats ? "..." : "");
  if (option.names.empty()) return values;
  return fmt::format("{}{}{}", fmt::join(option.names, ", "), values.empty() ? "" : " ", values);
}

}  // namespace

std::string help_page(const CommandText& command, std::size_t width) {
  std::string page = wrapped(command.meaning, width, 0) + "\n\nUsage: " + command.usage() + "\n";
  if (!command.arguments.empty()) page += "\nArguments:\n";
  for (const OptionText& argument : command.arguments)
    page += entry(name_of(argument), argument.sentence(), width);
  if (!command.commands.empty()) page += "\nCommands:\n";
  for (const CommandText& child : command.commands)
    page +=
        entry(child.path.substr(command.path.empty() ? 0 : command.path.size() + 1), child.meaning, width);
  std::string group;
  for (const OptionText& option : command.options) {
    if (option.group != group) page += fmt::format("\n{}:\n", option.group);
    group = option.group;
    page += entry(name_of(option), option.sentence(), width);
  }
  if (!command.examples.empty()) page += "\nExamples:\n";
  for (const std::string& example : command.examples) page += "  " + example + "\n";
  if (!command.commands.empty())
    page += fmt::format("\n`fringetwin help {}COMMAND` says more of a command.\n",
                        command.path.empty() ? "" : command.path + " ");
  if (!command.exit_codes.empty()) page += "\n" + wrapped(command.exit_codes, width, 0) + "\n";
  return page;
}

std::shared_ptr<CLI::FormatterBase> help_formatter() {
  return std::make_shared<CLI::FormatterLambda>(
      [](const CLI::App* app, const std::string& /*name*/, CLI::AppFormatMode /*mode*/) {
        return help_page(command_text(*app));
      });
}

}  // namespace fringetwin::cli
