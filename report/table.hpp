// SPDX-License-Identifier: Apache-2.0
// Writes HTML tables whose columns carry a unit and an alignment.
#pragma once
#include <string>
#include <vector>

namespace fringetwin::report {

enum class Align { left, right };

struct Column {
  std::string header;
  std::string unit = {};  ///< printed small below the header; empty for none
  Align align = Align::right;
};
/// Returns a column of words, which stand at the left.
inline Column text_column(const std::string& header, const std::string& unit = "") {
  return {header, unit, Align::left};
}

/// Returns a table's HTML in a box of its own, which scrolls sideways where the table is wider than the page,
/// and to which the Tab key leads, so that arrow keys scroll it; `name` is text and read out there.
std::string table_box_html(const std::string& name, const std::string& table_html,
                           const std::string& css_class = "");

/// Cells are text, escaped on output; words of the glossary in heads, and below "verdict", say what they
/// mean.
struct Table {
  struct Row {
    std::vector<std::string> cells;
    std::string css_class;  ///< "pass", "fail", "group", "fault" or empty
    std::string link = {};  ///< an address (report::url_path) that the first cell leads to; may be empty
  };
  std::string caption;
  bool cards = false;  ///< on a narrow screen each row is a block of its own, with the heads beside its cells
  std::vector<Column> columns;
  std::vector<Row> rows;

  /// Fewer cells than columns: the rest stays empty; more is a programming fault.
  void add_row(std::vector<std::string> cells, const std::string& css_class = "");
  std::string html() const;
};

}  // namespace fringetwin::report
