// SPDX-License-Identifier: Apache-2.0
#include "twin/file/toml_bounds.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "twin/base/safe_file.hpp"

namespace fringetwin {
namespace {

/// Returns where the string that begins at `at` has ended.
std::size_t end_of_toml_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string three(3, quote);
  const bool has_lines = text.substr(at, 3) == three;
  for (std::size_t i = at + (has_lines ? 3 : 1); i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"') {
      ++i;  // what is escaped ends nothing
    } else if (!has_lines && (text[i] == quote || text[i] == '\n')) {
      return i + 1;
    } else if (has_lines && text.substr(i, 3) == three) {
      i += 3;
      for (int k = 0; k < 2 && i < text.size() && text[i] == quote; ++k)
        ++i;  // two quotes may be its last text
      return i;
    }
  }
  return text.size();
}

/// What has been seen of a text so far.
struct TomlCount {
  std::size_t depth = 0, parts = 1, marks = 0, tables = 0;
  bool line_is_empty = true, in_header = false;

  void take(char c) {
    count_tables(c);
    marks += c == '.' || c == ',' || c == '=' || c == '[' || c == '{' ? 1u : 0u;
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (c == '.')
      ++parts;
    else if (c == ',' || c == '=' || c == '\n' || c == '[' || c == ']' || c == '{' || c == '}')
      parts = 1;
  }

 private:
  /// Dots of numbers are none of these: those of a key count when its '=' comes.
  void count_tables(char c) {
    if (c == '\n')
      in_header = false;
    else if (c == '[' && line_is_empty && depth == 0)
      in_header = true, ++tables;
    else if (c == '=')
      tables += parts - 1;
    else if (c == '.' && in_header)
      ++tables;
    line_is_empty = c == '\n' || (line_is_empty && (c == ' ' || c == '\t'));
  }
};

}  // namespace

std::optional<TomlExcess> toml_excess(std::string_view text) {
  const double most_marks = static_cast<double>(kMostTomlMarks) * file_limits_factor();
  const double most_tables = static_cast<double>(kMostTomlTables) * file_limits_factor();
  TomlCount count;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (c == '"' || c == '\'') {
      at = end_of_toml_string(text, at);
      continue;
    }
    count.take(c);
    ++at;
    const auto excess = [&](std::string what, std::string hint) {
      const auto begin = text.begin();
      const auto lines = std::count(begin, begin + static_cast<std::ptrdiff_t>(at), '\n');
      return TomlExcess{static_cast<std::size_t>(lines) + 1, std::move(what), std::move(hint)};
    };
    if (count.parts > kMostKeyParts)
      return excess(fmt::format("a key has more than {} parts", kMostKeyParts), "no key of ours has so many");
    if (count.depth > kDeepestValue)
      return excess(fmt::format("arrays or tables stand more than {} deep in each other", kDeepestValue),
                    "is a bracket left open?");
    if (static_cast<double>(count.tables) > most_tables)
      return excess(fmt::format("the file has more than {:.0f} headers and dots in keys", most_tables),
                    "--limits 10 reads ten times as much");
    if (static_cast<double>(count.marks) > most_marks)
      return excess(fmt::format("the file has more than {:.0f} keys and values", most_marks),
                    "--limits 10 reads ten times as much");
  }
  return std::nullopt;
}

}  // namespace fringetwin
