// SPDX-License-Identifier: Apache-2.0
// Takes a TOML text apart into its headers and keys and says at which bytes each stands, so that one value
// can be changed and every other byte left alone.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace fringetwin {

/// The way to a table or a value: names, and "[1]" behind the name of a list of tables.
using TomlPath = std::vector<std::string>;

/// A header or a key with its value.
struct TomlStatement {
  bool is_header = false;
  TomlPath path;                               ///< of the table that a header opens, or of the key
  TomlPath table;                              ///< whose header stands above; of a header, the table itself
  std::size_t begin = 0, end = 0;              ///< its lines, the last line's break included
  std::size_t value_begin = 0, value_end = 0;  ///< of a key
  std::size_t line = 0;                        ///< from 1
};

/// Returns the statements of a text, in their order. The text must be TOML (toml++ has parsed it); of another
/// one some statements are returned, and nothing outside of it is read.
std::vector<TomlStatement> toml_statements(std::string_view text);

/// Returns true where `path` begins with `begin`, or is the same.
bool begins_with(const TomlPath& path, const TomlPath& begin);

/// Returns "camera.sensor", as a header has it.
std::string header_text(const TomlPath& path);

}  // namespace fringetwin
