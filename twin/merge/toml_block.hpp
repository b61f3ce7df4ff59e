// SPDX-License-Identifier: Apache-2.0
// Holds values that a command has found for a twin.toml: which key of which table becomes what.
#pragma once
#include <string>
#include <vector>

namespace fringetwin {

/// A key and its value, both as they stand in a file.
struct TomlKey {
  std::string name, value;
  std::string comment = {};  ///< what a new line says behind the value; a line that is there keeps its own
};

/// Keys that cannot stand beside those of a block, and what the table needs in their place: a camera with
/// `model` needs all of lens and pose once its lens is its own. Where one of `keys` was there, `also` go with
/// them.
struct TomlExclusion {
  std::vector<std::string> keys;
  std::vector<TomlKey> instead;
  std::vector<std::string> also = {};
};

/// The keys of one table of a file.
struct TomlBlock {
  std::vector<std::string> table;  ///< {"projector"}, {"camera", "sensor"}
  std::string entry = {};          ///< which [[camera]], by its name; empty: a table of its own
  std::vector<TomlKey> keys = {};
  std::vector<TomlExclusion> exclusions = {};
  bool may_be_new = false;  ///< whether the file may lack the first part of `table`, too
};

}  // namespace fringetwin
