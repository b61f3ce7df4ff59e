// SPDX-License-Identifier: Apache-2.0
#include "twin/file/opencv_storage.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "twin/base/errors.hpp"

namespace fringetwin {
namespace {

constexpr std::size_t kDeepestStorage = 64;  // a calibration is three levels deep

std::string_view without_blanks(std::string_view s) {
  const auto first = s.find_first_not_of(" \t\r\n");
  return first == std::string_view::npos ? "" : s.substr(first, s.find_last_not_of(" \t\r\n") - first + 1);
}

class StorageText {
 public:
  StorageText(std::string_view text, const std::filesystem::path& file,
              const std::function<void(const StoredEntry&)>& visit)
      : text_(text), file_(file), visit_(visit) {}

  void read() {
    if (is_at("\xef\xbb\xbf")) at_ = 3;  // editors put a byte order mark there
    skip_space();
    const std::string_view start = text_.substr(at_);
    if (start.starts_with("%YAML")) return read_yaml();
    if (start.starts_with("<?xml")) return read_xml();
    if (start.starts_with('{')) return read_json();
    fail("is neither YAML, XML nor JSON as OpenCV writes it");
  }

 private:
  // ---------------------------------------------------------------- what all forms share

  [[noreturn]] void fail(const std::string& what) const {
    const auto line = 1 + std::ranges::count(text_.substr(0, at_), '\n');
    throw UserError(ExitCode::input, file_.string() + ":" + std::to_string(line), what);
  }

  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool is_at(std::string_view word) const { return text_.substr(at_).starts_with(word); }
  bool at_line_end() const { return at_ >= text_.size() || peek() == '\n' || peek() == '\r'; }
  void move_to(std::string_view word) { at_ = std::min(text_.find(word, at_), text_.size()); }
  void skip_blanks() { at_ = std::min(text_.find_first_not_of(" \t", at_), text_.size()); }

  void skip_space() {
    for (;;) {
      at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size());
      if (peek() != '#' && !is_at("//")) return;  // comments of YAML, of JSON
      move_to("\n");
    }
  }

  static void keep(StoredEntry& entry, std::string_view key, std::string_view value) {
    if (key == "rows") entry.rows = without_blanks(value);
    if (key == "cols") entry.cols = without_blanks(value);
    if (key == "dt") entry.dt = without_blanks(value);
    if (key == "data") entry.data = without_blanks(value);
  }

  // ---------------------------------------------------------------- JSON, and the same form within YAML

  void skip_quoted() {
    const char quote = text_[at_++];
    while (at_ < text_.size() && text_[at_] != quote) at_ += text_[at_] == '\\' ? 2 : 1;
    if (at_ >= text_.size()) break_off("a string");
    ++at_;
  }

  [[noreturn]] void break_off(const std::string& within) {
    at_ = text_.size();
    fail("the file ends within " + within);
  }

  /// Takes a string, a bracket with all that is in it, or a word up to a comma, a bracket or the line's end.
  std::string_view take_value() {
    const std::size_t start = at_;
    std::string brackets;  // the closing ones that are due
    for (;; ++at_) {
      if (brackets.empty() &&
          (at_line_end() || std::string_view(",]}#").find(peek()) != std::string_view::npos))
        break;
      if (at_ >= text_.size()) break_off("brackets");
      const char c = peek();
      const bool starts_word =
          at_ == start || std::string_view("[{,: \t\n").find(text_[at_ - 1]) != std::string_view::npos;
      if ((c == '"' || c == '\'') && starts_word) {
        skip_quoted();
        if (brackets.empty()) break;
        --at_;
      } else if (c == '[' || c == '{') {
        if (brackets.size() == kDeepestStorage) fail("brackets are nested too deeply");
        brackets += c == '[' ? ']' : '}';
      } else if (c == ']' || c == '}') {
        if (brackets.back() != c) fail(std::string("expected '") + brackets.back() + "', found '" + c + "'");
        brackets.pop_back();
        if (brackets.empty()) {
          ++at_;
          break;
        }
      } else if (c == '#') {
        move_to("\n");
        --at_;
      }
    }
    return text_.substr(start, at_ - start);
  }

  /// Takes "{ key: value, ... }"; on_key(key) takes the value.
  template <class OnKey>
  void take_map(OnKey on_key) {
    ++at_;
    for (;;) {
      skip_space();
      if (peek() == '}') break;
      const std::size_t start = at_;
      if (peek() == '"')
        skip_quoted();
      else
        at_ = std::min(text_.find_first_of(":,[]{}\n", at_), text_.size());
      std::string_view key = without_blanks(text_.substr(start, at_ - start));
      if (key.starts_with('"')) key = key.substr(1, key.size() - 2);
      skip_space();
      if (at_ >= text_.size()) break_off("brackets");
      if (peek() != ':') fail("expected a key and ':'");
      ++at_;
      skip_space();
      on_key(key);
      skip_space();
      if (at_ >= text_.size()) break_off("brackets");
      if (peek() == ',')
        ++at_;
      else if (peek() != '}')
        fail("expected ',' or '}'");
    }
    ++at_;
  }

  void take_matrix_or_value(StoredEntry& entry) {
    if (peek() != '{')
      entry.value = without_blanks(take_value());
    else
      take_map([&](std::string_view key) { keep(entry, key, take_value()); });
  }

  void read_json() {
    take_map([&](std::string_view key) {
      StoredEntry entry{.key = key};
      take_matrix_or_value(entry);
      visit_(entry);
    });
  }

  // ---------------------------------------------------------------- YAML

  bool at_quoted_or_bracket() const {
    return at_ < text_.size() && std::string_view("\"'[{").find(peek()) != std::string_view::npos;
  }

  /// Takes "key:" if this line has it.
  std::string_view take_yaml_key() {
    if (at_quoted_or_bracket()) return "";
    const std::size_t end = text_.find_first_of(":\r\n", at_);
    if (end == std::string_view::npos || text_[end] != ':') return "";
    const std::string_view key = without_blanks(text_.substr(at_, end - at_));
    at_ = end + 1;
    skip_blanks();
    if (peek() == '!') at_ = std::min(text_.find_first_of(" \r\n", at_), text_.size());  // a type
    skip_blanks();
    return key;
  }

  std::string_view take_yaml_value() {
    if (at_quoted_or_bracket()) return take_value();
    const std::string_view rest = text_.substr(at_, text_.find_first_of("#\r\n", at_) - at_);
    at_ += rest.size();
    return without_blanks(rest);
  }

  /// Passes over "- " and what it stands before: no key of a matrix is one of a sequence.
  bool skip_item() {
    if (!is_at("- ") && !is_at("-\n") && !is_at("-\r")) return false;
    while (is_at("- ")) ++at_, skip_blanks();
    take_yaml_key();
    take_yaml_value();
    return true;
  }

  void start_yaml_entry(StoredEntry& entry) {
    if (!entry.key.empty()) visit_(entry);
    entry = {.key = take_yaml_key()};
    if (entry.key.empty()) fail("is no line of a calibration; it has names with matrices below: \"M1: ...\"");
    if (peek() == '{')
      take_matrix_or_value(entry);
    else
      entry.value = take_yaml_value();
  }

  void read_yaml() {
    StoredEntry entry;
    std::size_t child_indent = 0;  // of the keys below the entry; 0: none yet
    std::string_view last_key;
    for (; at_ < text_.size(); move_to("\n"), ++at_) {
      const std::size_t line_start = at_;
      at_ = std::min(text_.find_first_not_of(' ', at_), text_.size());
      const std::size_t indent = at_ - line_start;
      if (peek() == '\t') fail("has a tab, which YAML forbids");
      if (at_line_end() || peek() == '#') continue;
      if (indent == 0 && (peek() == '%' || is_at("---") || is_at("..."))) continue;
      if (!entry.key.empty() && skip_item()) {
        child_indent = std::string_view::npos;  // keys below are those of an item
        continue;
      }
      if (indent == 0) {
        start_yaml_entry(entry);
        child_indent = 0;
        last_key = "";
        continue;
      }
      if (child_indent == 0) child_indent = indent;
      const bool is_value = peek() == '[' || peek() == '{';  // of the key on the line before
      const std::string_view key = is_value ? "" : take_yaml_key(), value = take_yaml_value();
      if (is_value && last_key == "data" && entry.data.empty()) keep(entry, last_key, value);
      if (is_value || indent != child_indent) continue;
      keep(entry, key, value);
      last_key = key;
    }
    at_ = text_.size();
    if (!entry.key.empty()) visit_(entry);
  }

  // ---------------------------------------------------------------- XML

  void read_xml() {
    StoredEntry entry;
    std::vector<std::string_view> open;
    std::size_t content = 0, last_opened = 0;  // where the text of the last tag begins, and its depth
    for (move_to("<"); at_ < text_.size(); move_to("<")) {
      const std::size_t start = at_;
      move_to(is_at("<!--") ? "-->" : ">");
      if (at_ == text_.size()) break_off("a tag");
      std::string_view tag = text_.substr(start + 1, at_ - start - 1);
      ++at_;
      if (tag.starts_with('!') || tag.starts_with('?') || tag.ends_with('/')) continue;
      const bool closes = tag.starts_with('/');
      tag.remove_prefix(closes ? 1 : 0);
      const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n"));
      if (!closes) {
        if (open.size() == kDeepestStorage) fail("tags are nested too deeply");
        open.push_back(name);
        if (open.size() == 2) entry = {.key = name};
        content = at_;
        last_opened = open.size();
        continue;
      }
      if (open.empty() || open.back() != name) fail("a closing tag has no opening one");
      if (open.size() == 3) keep(entry, name, text_.substr(content, start - content));
      if (open.size() == 2) {
        if (last_opened == 2) entry.value = without_blanks(text_.substr(content, start - content));
        visit_(entry);
      }
      open.pop_back();
    }
    if (!open.empty()) fail("the file ends within a tag that is open");
  }

  std::string_view text_;
  const std::filesystem::path& file_;
  const std::function<void(const StoredEntry&)>& visit_;
  std::size_t at_ = 0;
};

}  // namespace

void visit_opencv_storage(std::string_view text, const std::filesystem::path& file,
                          const std::function<void(const StoredEntry&)>& visit) {
  StorageText(text, file, visit).read();
}

}  // namespace fringetwin
