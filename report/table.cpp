// SPDX-License-Identifier: Apache-2.0
#include "report/table.hpp"

#include "report/text.hpp"
#include "report/words.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::report {
namespace {

const char* align_class(Align align) { return align == Align::left ? "l" : "r"; }

/// Returns a column's head on one line: "phase [rad]".
std::string words_of_head(const Column& column) {
  return column.header + (column.unit.empty() ? "" : " [" + column.unit + "]");
}

/// Says whether the cells below a head are verdicts, not names that others gave: a study may call a number
/// "gain".
bool verdicts(const Column& column) { return column.header == "verdict"; }

/// Returns how a table is called before it is read out, caption and all: by its heads.
std::string name_of(const Table& table) {
  std::string heads;
  for (const Column& column : table.columns)
    if (!column.header.empty()) heads += (heads.empty() ? "" : ", ") + column.header;
  return heads;
}

}  // namespace

std::string table_box_html(const std::string& name, const std::string& table_html,
                           const std::string& css_class) {
  return "<div class=\"table" + (css_class.empty() ? "" : " " + css_class) +
         "\" tabindex=\"0\" role=\"group\" aria-label=\"Table: " + escape_html(name) + "\">" + table_html +
         "</div>\n";
}

void Table::add_row(std::vector<std::string> cells, const std::string& css_class) {
  FT_CHECK(cells.size() <= columns.size(), "a table row has more cells than the table has columns");
  cells.resize(columns.size());
  rows.push_back({.cells = std::move(cells), .css_class = css_class});
}

std::string Table::html() const {
  std::string out = "<table>";
  if (!caption.empty()) out += "<caption>" + escape_html(caption) + "</caption>";
  out += "<thead><tr>";
  for (const Column& column : columns) {
    out += std::string("<th scope=\"col\" class=\"") + align_class(column.align) + "\">" +
           word_html(column.header);
    if (!column.unit.empty()) out += "<span class=\"unit\">" + escape_html(column.unit) + "</span>";
    out += "</th>";
  }
  out += "</tr></thead>\n<tbody>";
  for (const Row& row : rows) {
    out += row.css_class.empty() ? "<tr>" : "<tr class=\"" + escape_html(row.css_class) + "\">";
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      const std::string link = i == 0 ? escape_html(row.link) : "",
                        text = verdicts(columns[i]) ? words_html(row.cells[i]) : escape_html(row.cells[i]);
      out += std::string("<td class=\"") + align_class(columns[i].align) + "\"" +
             (cards && i > 0 ? " data-head=\"" + escape_html(words_of_head(columns[i])) + "\">" : ">") +
             (link.empty() ? text : "<a href=\"" + link + "\">" + text + "</a>") + "</td>";
    }
    out += "</tr>\n";
  }
  return table_box_html(name_of(*this), out + "</tbody></table>", cards ? "cards" : "");
}

}  // namespace fringetwin::report
