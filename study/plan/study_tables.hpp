// SPDX-License-Identifier: Apache-2.0
// Reads the tables of STUDY.toml that several kinds of studies have: values of keys ([[vary]], [[choose]])
// and what is recorded ([[record]]).
#pragma once
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "twin/file/toml_reader.hpp"

namespace fringetwin::study {

struct Range {
  double first = 0.0, last = 0.0;
  std::optional<int> count;  ///< of a grid or list
  bool log = false;
};
/// One [[vary]]: values that all its keys take together.
struct Variation {
  std::vector<std::string> keys;
  std::vector<std::string> values;             ///< TOML text; empty with a range; with `rows` the first key's
  std::vector<std::vector<std::string>> rows;  ///< or each key has its own: [value][key]
  std::optional<Range> range;
};
/// One [[record]]: a path into what `measure` writes, and the column it fills. What theory says of its mean,
/// and of its standard deviation over noise seeds, are records of their own: NAME.expected_mean and
/// NAME.expected_sigma.
struct Record {
  std::string result, name;
};

/// Returns "key" or "keys" of a [[vary]], [[uncertain]] or [[choose]]; none may be among those taken.
std::vector<std::string> read_study_keys(const TomlTable& table, std::set<std::string>* taken);

/// Reads a [[vary]] or [[choose]]. `sampled`: a range takes no count.
Variation read_variation(const TomlTable& table, bool sampled, std::set<std::string>* taken);

/// Reads all [[record]] tables.
std::vector<Record> read_records(const TomlTable& root);

}  // namespace fringetwin::study
