// SPDX-License-Identifier: Apache-2.0
// Reads our TOML files strictly: every complaint names file, line and key; unknown keys are errors that name
// the nearest known one.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/base/errors.hpp"
#include "twin/number/number_range.hpp"

namespace fringetwin {

/// One table of the file. Cheap to copy. Integers are accepted for reals; NaN and infinity are not.
class TomlTable {
 public:
  /// Parses a file; `code` is the exit code of every complaint about it. `settings`: path of a key -> TOML
  /// text put in its place (load_twin); complaints about it name the setting instead of a line.
  static TomlTable parse_file(const std::filesystem::path& file, ExitCode code,
                              const std::map<std::string, std::string>& settings = {});

  /// Call first: refuses every other key, naming the nearest known one.
  void allow(const std::vector<std::string>& keys) const;

  bool has(const std::string& key) const;
  std::vector<std::string> keys() const;  ///< in alphabetical order
  bool is_string(const std::string& key) const;
  bool is_number(const std::string& key) const;
  bool is_array(const std::string& key) const;
  bool is_table(const std::string& key) const;

  std::optional<double> number(const std::string& key, const NumberRange& range = {}) const;
  double number_or(const std::string& key, double otherwise, const NumberRange& range = {}) const;
  double required_number(const std::string& key, const NumberRange& range = {}) const;
  std::optional<int> integer(const std::string& key, int min, int max) const;
  int required_integer(const std::string& key, int min, int max) const;
  std::optional<bool> boolean(const std::string& key) const;
  std::optional<std::string> string(const std::string& key) const;
  std::string required_string(const std::string& key) const;
  /// The key "name" of a camera or an object, fit to become part of a file name (paths.hpp).
  std::string required_name() const;
  /// One of `choices`; a wrong one is answered with the nearest and the whole list.
  std::optional<std::string> choice(const std::string& key, const std::vector<std::string>& choices) const;
  std::string required_choice(const std::string& key, const std::vector<std::string>& choices) const;
  std::optional<std::vector<double>> numbers(const std::string& key, const NumberRange& range = {}) const;
  /// Lists of rows of `columns` numbers: one list where the array holds rows, else a list per entry; entries
  /// that are all empty are lists.
  std::optional<std::vector<std::vector<std::vector<double>>>> lists_of_rows(
      const std::string& key, std::size_t columns, const NumberRange& range = {}) const;
  std::optional<std::vector<std::string>> strings(const std::string& key) const;
  /// The number at a path of the whole file, in the language of `settings`; nothing where it is left out or
  /// is no number. Throws UserError(usage) where the path leads nowhere.
  std::optional<double> number_at(const std::string& path) const;
  /// The entries of an array of anything, each as TOML on one line.
  std::optional<std::vector<std::string>> toml_texts(const std::string& key) const;
  /// The same of an array of arrays that have `columns` entries each.
  std::optional<std::vector<std::vector<std::string>>> toml_rows(const std::string& key,
                                                                 std::size_t columns) const;
  /// An array of exactly n numbers.
  std::optional<Eigen::VectorXd> vector(const std::string& key, int n, const NumberRange& range = {}) const;
  Eigen::Vector3d required_vector3(const std::string& key) const;

  std::optional<TomlTable> table(const std::string& key) const;
  std::vector<TomlTable> tables(const std::string& key) const;  ///< [[key]]; empty when absent
  /// Every scalar below this table as text, "a.b" = "text", arrays as a[0]...
  std::map<std::string, std::string> flattened() const;

  /// "file:line" of the key, or of this table where the key is absent.
  std::string where(const std::string& key = "") const;
  /// Throws UserError at the key: "file:line: key what; hint".
  [[noreturn]] void fail(const std::string& key, const std::string& what, const std::string& hint = "") const;
  /// The key with its table, as in "camera[1].sensor.gain_dn" (counted from 0).
  std::string full_key(const std::string& key) const;

 private:
  struct Impl;
  explicit TomlTable(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  /// Returns the value of the key, null where there is none; fails unless it is `what`, a Value.
  template <class Value>
  const Value* find(const std::string& key, const char* what) const;
  std::shared_ptr<const Impl> impl_;
};

/// Replaces ${FRINGETWIN_CAPTURES} by captures_root() and makes the path absolute (tidy_path), relative to
/// `folder`. Other ${...} are refused (`where` names the place).
std::filesystem::path resolve_path(const std::string& text, const std::filesystem::path& folder,
                                   const std::string& where, ExitCode code);

/// Returns a text as a string of TOML, in its quotes.
std::string toml_string(const std::string& text);

}  // namespace fringetwin
