// SPDX-License-Identifier: Apache-2.0
// Lists the tables of a result in the order of result.json, each with the fields of its rows and with the
// rows that a comparison or a measurement puts into it.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "compare/result/fields.hpp"
#include "compare/result/rows.hpp"
#include "measure/measurement.hpp"

namespace fringetwin::compare {

/// One table of result.json; `fits`, whose rows are maps, is not among them (fit_json.hpp).
struct Table {
  std::string key;
  bool is_list = true;  ///< false: the table is a single row
  const std::vector<Field>& (*fields)() = nullptr;
  /// The rows of a comparison, or the single row; null where the comparison has no such table.
  std::function<report::Json(const Comparison&)> of_comparison = nullptr;
  /// The same of a measurement; absent where a measurement has no such table.
  std::function<report::Json(const measure::Measurement&)> of_measurement = nullptr;

  /// Where the page shows the table as a plain one in a section of its own: its heading and caption. An empty
  /// heading: the page shows it elsewhere, or not at all.
  std::string heading = "", caption = "";
  /// The addresses of the rows of a comparison, which that section takes; absent for a single row.
  std::function<std::vector<const void*>(const Comparison&)> rows_of_comparison = nullptr;

  /// A measurement writes the table, too, without rows.
  Table& in_measurements();
  /// The table is a section of the page.
  Table& shown(const char* its_heading, const char* its_caption);
};

const std::vector<Table>& tables();

}  // namespace fringetwin::compare
