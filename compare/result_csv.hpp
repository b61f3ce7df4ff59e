// SPDX-License-Identifier: Apache-2.0
// Turns the tables of a result into CSV, which spreadsheets, R and pandas read (docs/formats/results.md,
// "Tables as CSV").
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fringetwin::compare {

struct CsvTable {
  std::string name;  ///< "fits", "causes_tested"
  std::string text;  ///< RFC 4180: a line of heads, then a line per row, ended by CR LF
};

/// Returns the tables of a result: each list of rows is one, and a list within a row is one more, whose rows
/// begin with the texts of the row that it is in. A list of numbers takes a column for each (`center_mm.0`),
/// a table within a row its keys (`real.radius_mm`); no number, and null, is an empty cell.
std::vector<CsvTable> result_tables(const nlohmann::ordered_json& result);

/// Returns those of a result.json, or of the folder of a run. Throws UserError(input) as read_result_file().
std::vector<CsvTable> result_tables_of(const std::filesystem::path& path);

}  // namespace fringetwin::compare
