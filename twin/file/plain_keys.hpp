// SPDX-License-Identifier: Apache-2.0
// Reads the settings whose keys twin.hpp lists (list_keys): the keys of their table are checked, and what is
// a plain number or switch is put where the list says.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "twin/file/toml_reader.hpp"

namespace fringetwin {

/// Collects the names of all keys of a list.
struct KeyNames {
  std::vector<std::string> names;
  template <class... Place>
  void operator()(const char* key, const Place&...) {
    names.emplace_back(key);
  }
};

/// Reads the keys of a list that set a member; it stays as it is where its key is left out.
template <class S>
struct KeyReader {
  const TomlTable& table;
  S& settings;
  void operator()(const char*) const {}
  void operator()(const char* key, bool S::*member) const {
    settings.*member = table.boolean(key).value_or(settings.*member);
  }
  void operator()(const char* key, int S::*member, int min, int max) const {
    settings.*member = table.integer(key, min, max).value_or(settings.*member);
  }
  void operator()(const char* key, std::optional<int> S::*member, int min, int max) const {
    settings.*member = table.integer(key, min, max);
  }
  void operator()(const char* key, double S::*member, const NumberRange& range) const {
    settings.*member = table.number_or(key, settings.*member, range);
  }
  void operator()(const char* key, std::optional<double> S::*member, const NumberRange& range) const {
    settings.*member = table.number(key, range);
  }
};

/// Returns the names of all keys in the table of the settings S.
template <class S>
std::vector<std::string> names_of_keys() {
  KeyNames keys;
  list_keys(keys, static_cast<const S*>(nullptr));
  return keys.names;
}

template <class S>
void read_plain_keys(const TomlTable& table, S& settings) {
  const KeyReader<S> keys{table, settings};
  list_keys(keys, &settings);
}

}  // namespace fringetwin
