// SPDX-License-Identifier: Apache-2.0
#include "cli/manual/man_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>

namespace fringetwin::cli {
namespace {

/// Returns the text as troff prints it: nothing in it is a request, and hyphens can be copied as such.
std::string plain_troff(const std::string& text) {
  static const std::map<char, std::string> kEscapes = {{'\\', "\\e"},  {'-', "\\-"},   {'\'', "\\(aq"},
                                                       {'`', "\\(ga"}, {'^', "\\(ha"}, {'~', "\\(ti"},
                                                       {'"', "\\(dq"}};
  std::string out;
  for (const char c : text) {
    if (c == '.' && (out.empty() || out.back() == '\n')) out += "\\&";
    const auto escape = kEscapes.find(c);
    if (escape != kEscapes.end())
      out += escape->second;
    else
      out += c;
  }
  return out;
}

std::string option_head(const OptionText& option) {
  std::string head;
  for (const std::string& name : option.names)
    head += fmt::format("{}\\fB{}\\fR", head.empty() ? "" : ", ", plain_troff(name));
  if (option.value.empty()) return head;
  return fmt::format("{}{}\\fI{}\\fR{}", head, head.empty() ? "" : " ", plain_troff(option.value),
                     option.repeats ? "..." : "");
}

std::string option_entry(const OptionText& option) {
  return fmt::format(".TP\n{}\n{}\n", option_head(option), plain_troff(option.sentence()));
}

std::string without_start(const std::string& start, const std::string& text) {
  return text.starts_with(start) ? text.substr(start.size()) : text;
}

/// The meaning as it stands behind the name of a page: without that name, and no sentence.
std::string what_it_is(const CommandText& command) {
  std::string text = without_start("fringetwin: ", command.meaning);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string see_also(const CommandText& command) {
  std::string names;
  for (const CommandText& child : command.commands)
    names += fmt::format("{}\\fB{}\\fR(1)", names.empty() ? "" : ", ", plain_troff(man_name(child.path)));
  std::string above = command.path;
  while (!above.empty()) {
    above.resize(above.find(' ') == std::string::npos ? 0 : above.rfind(' '));
    names += fmt::format("{}\\fB{}\\fR(1)", names.empty() ? "" : ", ", plain_troff(man_name(above)));
  }
  return names;
}

}  // namespace

std::string man_name(const std::string& command_path) {
  std::string name = command_path.empty() ? "fringetwin" : "fringetwin-" + command_path;
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string man_page(const CommandText& command, const std::string& version) {
  std::string title = man_name(command.path);
  std::ranges::transform(title, title.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string page = fmt::format(".TH {} 1 \"\" \"fringetwin {}\" \"User Commands\"\n", plain_troff(title),
                                 plain_troff(version));
  page += fmt::format(".SH NAME\n{} \\- {}\n", plain_troff(man_name(command.path)),
                      plain_troff(what_it_is(command)));
  page += fmt::format(".SH SYNOPSIS\n{}\n", plain_troff(command.usage()));
  if (!command.arguments.empty()) page += ".SH ARGUMENTS\n";
  for (const OptionText& argument : command.arguments) page += option_entry(argument);
  if (!command.commands.empty()) page += ".SH COMMANDS\n";
  for (const CommandText& child : command.commands)
    page += fmt::format(".TP\n\\fB{}\\fR\n{}\n", plain_troff(child.path), plain_troff(child.meaning));
  page += ".SH OPTIONS\n";
  std::string group;
  for (const OptionText& option : command.options) {
    if (option.group != group) page += fmt::format(".SS {}\n", plain_troff(option.group));
    group = option.group;
    page += option_entry(option);
  }
  if (!command.examples.empty()) page += ".SH EXAMPLES\n.EX\n";
  for (const std::string& example : command.examples) page += plain_troff(example) + "\n";
  if (!command.examples.empty()) page += ".EE\n";
  if (!command.exit_codes.empty())
    page += ".SH EXIT STATUS\n" + plain_troff(without_start("Exit codes: ", command.exit_codes)) + "\n";
  return page + ".SH SEE ALSO\n" + see_also(command) + "\n";
}

}  // namespace fringetwin::cli
