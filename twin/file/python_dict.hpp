// SPDX-License-Identifier: Apache-2.0
// Reads the Python dict literal that an mrcal .cameramodel file is: its text goes in, its keys with their
// values as text come out.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace fringetwin {

/// Holds one "'key': value" pair: the value as it is written, and the line on which it starts.
struct PythonDictEntry {
  std::string key;
  std::string_view value;  ///< into the parsed text
  int line = 0;
};

/// Reads one dict literal: strings ('', "", b'', with escapes), numbers, names, nested lists, tuples and
/// dicts, comments and trailing commas; nothing but space and comments around it. Values are checked
/// for syntax, not interpreted. Throws UserError(input) with file and line.
class PythonDictParser {
 public:
  PythonDictParser(const std::filesystem::path& file, std::string_view text) : file_(file), text_(text) {}
  std::vector<PythonDictEntry> parse();

  [[noreturn]] void fail(int line, const std::string& what) const;

  /// Returns a string value without quotes (no escapes allowed).
  std::string to_string(const PythonDictEntry& entry) const;
  /// Returns the numbers of a flat list of finite numbers, locale-free and correctly rounded.
  std::vector<double> to_numbers(const PythonDictEntry& entry) const;

 private:
  void skip_space();
  char peek() const { return position_ < text_.size() ? text_[position_] : '\0'; }
  void expect(char c);
  void skip_value(int depth);
  void skip_sequence(char close, int depth);
  void skip_string();
  int line_breaks(std::size_t from, std::size_t to) const;
  int line_at(std::size_t position) const { return 1 + line_breaks(0, position); }

  std::filesystem::path file_;
  std::string_view text_;
  std::size_t position_ = 0;
};

}  // namespace fringetwin
