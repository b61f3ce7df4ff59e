// SPDX-License-Identifier: Apache-2.0
// Reads the tables of STUDY.toml that several kinds of studies have: what is recorded ([[record]]), and the
// values that keys take ([[vary]], [[choose]]), which it returns as TOML text.
#pragma once
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "study/plan/study_point.hpp"
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

/// Returns all values in their order; of a range without `count` none.
std::vector<std::string> listed_values(const Variation& variation);
/// Returns the value at a place u in [0, 1]: along the range, or of the list the one in whose equal share u
/// lies.
std::string value_at(const Variation& variation, double u);

/// Gives all keys of the variation what they take with the i-th of its listed values.
void assign_listed(const Variation& variation, const std::vector<std::string>& values, std::size_t i,
                   Settings* settings);
/// Gives all keys of the variation what they take at the place u in [0, 1].
void assign_at(const Variation& variation, double u, Settings* settings);

}  // namespace fringetwin::study
