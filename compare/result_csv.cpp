// SPDX-License-Identifier: Apache-2.0
#include "compare/result_csv.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "compare/result_file.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

using Json = nlohmann::ordered_json;
using Cells = std::vector<std::pair<std::string, std::string>>;  ///< a row: heads and texts

bool is_list_of_rows(const Json& value) {
  return value.is_array() && !value.empty() &&
         std::ranges::all_of(value, [](const Json& row) { return row.is_object(); });
}

/// A text that a spreadsheet would run as a formula stays a text.
std::string cell(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string text = value.get<std::string>();
  if (!text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos)
    text.insert(0, 1, '\'');
  return report::csv_cell(text);
}

class Tables {
 public:
  void add_rows(const std::string& table, const Json& rows, const Cells& names) {
    for (const Json& row : rows) {
      Cells cells = names;
      add_cells(row, "", cells);
      Cells named = names;
      for (const auto& [key, value] : row.items())
        if (value.is_string()) named.emplace_back(key, cell(value));
      at(table).push_back(std::move(cells));
      add_inner(table, row, named);
    }
  }

  /// Adds the lists of rows that stand in a table.
  void add_inner(const std::string& table, const Json& object, const Cells& names) {
    for (const auto& [key, value] : object.items()) {
      const std::string name = table.empty() ? key : table + "_" + key;
      if (is_list_of_rows(value))
        add_rows(name, value, names);
      else if (value.is_object())
        add_inner(name, value, names);
    }
  }

  std::vector<CsvTable> written() const {
    std::vector<CsvTable> out;
    for (const auto& [name, rows] : tables_) out.push_back({name, text_of(rows)});
    return out;
  }

 private:
  using Rows = std::vector<Cells>;

  /// Refuses a name that is none of this program's tables': it becomes that of a file.
  Rows& at(const std::string& table) {
    if (table.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos)
      throw UserError(ExitCode::input, "result.json", "\"" + table + "\" is no name of a table",
                      "give a result that this program wrote");
    for (auto& [name, rows] : tables_)
      if (name == table) return rows;
    return tables_.emplace_back(table, Rows{}).second;
  }

  static void add_cells(const Json& value, const std::string& head, Cells& cells) {
    const std::string before = head.empty() ? "" : head + ".";
    if (value.is_object()) {
      for (const auto& [key, part] : value.items()) add_cells(part, before + key, cells);
    } else if (value.is_array()) {
      for (std::size_t i = 0; !is_list_of_rows(value) && i < value.size(); ++i)
        add_cells(value[i], before + std::to_string(i), cells);
    } else {
      cells.emplace_back(head, cell(value));
    }
  }

  static std::string text_of(const Rows& rows) {
    std::vector<std::string> heads;
    std::set<std::string> met;
    for (const Cells& row : rows)
      for (const auto& [head, text] : row)
        if (met.insert(head).second) heads.push_back(head);
    std::string out;
    const auto add_line = [&](const auto& text_at) {
      for (std::size_t i = 0; i < heads.size(); ++i) out += (i > 0 ? "," : "") + text_at(i);
      out += "\r\n";
    };
    add_line([&](std::size_t i) { return cell(heads[i]); });
    for (const Cells& row : rows) {
      std::map<std::string, std::string> by_head(row.begin(), row.end());
      add_line([&](std::size_t i) { return by_head[heads[i]]; });
    }
    return out;
  }

  std::vector<std::pair<std::string, Rows>> tables_;  ///< in the order of the result
};

}  // namespace

std::vector<CsvTable> result_tables(const nlohmann::ordered_json& result) {
  Tables tables;
  tables.add_inner("", result, {});
  return tables.written();
}

std::vector<CsvTable> result_tables_of(const std::filesystem::path& path) {
  const std::filesystem::path file = read_result_file(path).file;  // and is a result
  std::ifstream in(file);
  return result_tables(Json::parse(in));  // again, for the order of its keys
}

}  // namespace fringetwin::compare
