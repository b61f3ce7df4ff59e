// SPDX-License-Identifier: Apache-2.0
#include "twin/file/python_dict.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "twin/base/errors.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin {
namespace {

constexpr int kMaxDepth = 64;            // a hostile file must not overflow the stack
constexpr std::size_t kMostKeys = 1000;  // mrcal writes less than ten, and each is compared with all before
constexpr std::size_t kMostOfList = 2'000'000;  // twice what the largest lens model takes (lens_name.cpp)
constexpr std::size_t kShownOfToken = 40;

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v'; }

bool is_word(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.' ||
         c == '+' || c == '-';
}

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && is_space(s.front())) s.remove_prefix(1);
  while (!s.empty() && is_space(s.back())) s.remove_suffix(1);
  return s;
}

std::string without_comments(std::string_view text) {
  std::string kept;
  bool comment = false;
  for (const char c : text) {
    if (c == '#') comment = true;
    if (c == '\n') comment = false;
    if (!comment) kept += c;
  }
  return kept;
}

/// Returns the finite number that the token writes, with one '+' before it if Python wrote it so.
std::optional<double> finite_number(std::string_view token) {
  if (token.starts_with('+')) {
    token.remove_prefix(1);
    if (token.starts_with('-')) return std::nullopt;
  }
  const std::optional<double> value = parse_number<double>(token);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace

void PythonDictParser::fail(int line, const std::string& what) const {
  throw UserError(ExitCode::input, file_.string() + ":" + std::to_string(line), what);
}

int PythonDictParser::line_breaks(std::size_t from, std::size_t to) const {
  return static_cast<int>(std::ranges::count(text_.substr(from, to - from), '\n'));
}

void PythonDictParser::skip_space() {
  while (position_ < text_.size()) {
    if (text_[position_] == '#') {
      position_ = std::min(text_.find('\n', position_), text_.size());
    } else if (is_space(text_[position_])) {
      ++position_;
    } else {
      return;
    }
  }
}

void PythonDictParser::expect(char c) {
  skip_space();
  if (position_ >= text_.size())
    fail(line_at(position_), std::string("the file ends where '") + c + "' is due");
  if (peek() != c) fail(line_at(position_), std::string("expected '") + c + "', found '" + peek() + "'");
  ++position_;
}

void PythonDictParser::skip_string() {
  const std::size_t start = position_;
  const char quote = text_[position_++];
  while (position_ < text_.size() && text_[position_] != quote) position_ += text_[position_] == '\\' ? 2 : 1;
  if (position_ >= text_.size()) fail(line_at(start), "a string does not end");
  ++position_;
}

void PythonDictParser::skip_sequence(char close, int depth) {
  ++position_;  // the opening bracket
  for (;;) {
    skip_space();
    if (peek() == close) break;
    skip_value(depth + 1);
    if (close == '}') {
      expect(':');
      skip_value(depth + 1);
    }
    skip_space();
    if (peek() != close) expect(',');
  }
  ++position_;
}

void PythonDictParser::skip_value(int depth) {
  skip_space();
  if (depth > kMaxDepth) fail(line_at(position_), "values are nested too deeply");
  const char c = peek();
  const char next = position_ + 1 < text_.size() ? text_[position_ + 1] : '\0';
  if (c == '\'' || c == '"') {
    skip_string();
  } else if (c == 'b' && (next == '\'' || next == '"')) {
    ++position_;
    skip_string();
  } else if (c == '[') {
    skip_sequence(']', depth);
  } else if (c == '(') {
    skip_sequence(')', depth);
  } else if (c == '{') {
    skip_sequence('}', depth);
  } else if (is_word(c)) {
    while (is_word(peek())) ++position_;
  } else if (position_ >= text_.size()) {
    fail(line_at(position_), "the file ends inside the dict");
  } else {
    fail(line_at(position_), std::string("unexpected '") + c + "'");
  }
}

std::vector<PythonDictEntry> PythonDictParser::parse() {
  std::vector<PythonDictEntry> entries;
  position_ = 0;
  std::size_t counted_to = 0;  // lines are counted once, not from the start for every key
  int line = 1;
  expect('{');
  for (;;) {
    skip_space();
    if (peek() == '}') break;
    const std::size_t key_start = position_;
    if (peek() != '\'' && peek() != '"') fail(line_at(position_), "expected a quoted key or '}'");
    skip_string();
    PythonDictEntry entry;
    entry.key = text_.substr(key_start + 1, position_ - key_start - 2);
    expect(':');
    skip_space();
    const std::size_t value_start = position_;
    line += line_breaks(counted_to, value_start);
    counted_to = value_start;
    entry.line = line;
    skip_value(0);
    entry.value = text_.substr(value_start, position_ - value_start);
    if (entries.size() == kMostKeys)
      fail(line, "the dict has more than " + std::to_string(kMostKeys) + " keys");
    entries.push_back(entry);
    skip_space();
    if (peek() != '}') expect(',');
  }
  ++position_;
  skip_space();
  if (position_ != text_.size()) fail(line_at(position_), "unexpected text after the closing '}'");
  return entries;
}

std::string PythonDictParser::to_string(const PythonDictEntry& entry) const {
  const std::string_view v = entry.value;
  const bool quoted = v.size() >= 2 && (v.front() == '\'' || v.front() == '"') && v.back() == v.front();
  if (!quoted || v.find('\\') != std::string_view::npos)
    fail(entry.line, "'" + entry.key + "' must be a plain quoted string");
  return std::string(v.substr(1, v.size() - 2));
}

std::vector<double> PythonDictParser::to_numbers(const PythonDictEntry& entry) const {
  const std::string_view v = entry.value;
  const bool list =
      v.size() >= 2 && ((v.front() == '[' && v.back() == ']') || (v.front() == '(' && v.back() == ')'));
  if (!list) fail(entry.line, "'" + entry.key + "' must be a list of numbers");
  const std::string inside = without_comments(v.substr(1, v.size() - 2));
  std::vector<double> numbers;
  std::string_view rest = trimmed(inside);
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const std::string_view token = trimmed(rest.substr(0, comma));
    const std::optional<double> value = finite_number(token);
    if (!value)
      fail(entry.line, "'" + entry.key + "' must be a list of finite numbers, '" +
                           std::string(token.substr(0, kShownOfToken)) + "' is none");
    if (numbers.size() == kMostOfList)
      fail(entry.line, "'" + entry.key + "' has more than " + std::to_string(kMostOfList) + " numbers");
    numbers.push_back(*value);
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return numbers;
}

}  // namespace fringetwin
