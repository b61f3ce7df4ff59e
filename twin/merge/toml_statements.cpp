// SPDX-License-Identifier: Apache-2.0
#include "twin/merge/toml_statements.hpp"

#include <algorithm>
#include <map>

namespace fringetwin {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Walks over the text from its begin to its end.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {
    if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;
  }

  std::vector<TomlStatement> statements() {
    while (true) {
      const std::size_t line_begin = at_;
      skip_blanks();
      if (at_ >= text_.size()) return std::move(found_);
      if (peek() != '#' && peek() != '\n') {
        TomlStatement statement;
        statement.begin = line_begin;
        statement.line = line_;
        if (peek() == '[')
          read_header(statement);
        else
          read_key(statement);
        skip_line();
        statement.end = at_;
        found_.push_back(std::move(statement));
      } else {
        skip_line();
      }
    }
  }

 private:
  /// NUL behind the end.
  char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  void step() {
    if (at_ >= text_.size()) return;
    if (text_[at_] == '\n') ++line_;
    ++at_;
  }
  void step(std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) step();
  }
  void skip_blanks() {
    while (is_blank(peek())) step();
  }
  void skip_line() {
    while (at_ < text_.size() && peek() != '\n') step();
    step();
  }

  void read_header(TomlStatement& statement) {
    statement.is_header = true;
    step();
    const bool is_list = peek() == '[';
    if (is_list) step();
    const TomlPath names = read_names(']');
    TomlPath path;
    for (std::size_t i = 0; i < names.size(); ++i) {
      path.push_back(names[i]);
      const bool is_last = i + 1 == names.size();
      if (is_last && is_list)
        path.push_back("[" + std::to_string(entries_[path]++) + "]");
      else if (const auto list = entries_.find(path); list != entries_.end())
        path.push_back("[" + std::to_string(list->second - 1) + "]");
    }
    table_ = path;
    statement.path = statement.table = std::move(path);
  }

  void read_key(TomlStatement& statement) {
    statement.table = statement.path = table_;
    const TomlPath names = read_names('=');
    statement.path.insert(statement.path.end(), names.begin(), names.end());
    step();  // =
    skip_blanks();
    statement.value_begin = at_;
    skip_value();
    std::size_t end = at_;
    while (end > statement.value_begin && is_blank(text_[end - 1])) --end;
    statement.value_end = end;
  }

  /// Reads names with points between them, up to the mark that ends them.
  TomlPath read_names(char mark) {
    TomlPath names;
    while (at_ < text_.size() && peek() != mark && peek() != '\n') {
      const char c = peek();
      if (is_blank(c) || c == '.') {
        step();
      } else if (c == '"' || c == '\'') {
        const std::size_t begin = at_ + 1;
        skip_string();
        names.emplace_back(text_.substr(begin, std::max(at_, begin + 1) - begin - 1));
      } else {
        const std::size_t begin = at_;
        while (at_ < text_.size() && !is_blank(peek()) && peek() != '.' && peek() != mark && peek() != '\n')
          step();
        names.emplace_back(text_.substr(begin, at_ - begin));
      }
    }
    return names;
  }

  /// Stops at the comment behind the value, or at the break of its line.
  void skip_value() {
    std::size_t depth = 0;
    while (at_ < text_.size()) {
      const char c = peek();
      if (depth == 0 && (c == '#' || c == '\n')) return;
      if (c == '"' || c == '\'') {
        skip_string();
        continue;
      }
      if (c == '#') {
        skip_line();
        continue;
      }
      if (c == '[' || c == '{') ++depth;
      if ((c == ']' || c == '}') && depth > 0) --depth;
      step();
    }
  }

  void skip_string() {
    const char quote = peek();
    const bool is_long = peek(1) == quote && peek(2) == quote;
    step(is_long ? 3 : 1);
    while (at_ < text_.size()) {
      if (peek() == '\\' && quote == '"') {
        step(2);
      } else if (!is_long && (peek() == quote || peek() == '\n')) {
        step(peek() == quote ? 1 : 0);
        return;
      } else if (is_long && peek() == quote && peek(1) == quote && peek(2) == quote) {
        step(3);
        while (peek() == quote) step();  // a long string may end in quotes of its own
        return;
      } else {
        step();
      }
    }
  }

  std::string_view text_;
  std::size_t at_ = 0, line_ = 1;
  TomlPath table_;
  std::map<TomlPath, std::size_t> entries_;  ///< of each list of tables, so far
  std::vector<TomlStatement> found_;
};

}  // namespace

std::vector<TomlStatement> toml_statements(std::string_view text) { return Scanner(text).statements(); }

bool begins_with(const TomlPath& path, const TomlPath& begin) {
  return begin.size() <= path.size() && std::equal(begin.begin(), begin.end(), path.begin());
}

std::string header_text(const TomlPath& path) {
  std::string text;
  for (const std::string& part : path)
    if (!part.starts_with('[')) text += (text.empty() ? "" : ".") + part;
  return text;
}

}  // namespace fringetwin
