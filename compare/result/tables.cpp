// SPDX-License-Identifier: Apache-2.0
#include "compare/result/tables.hpp"

#include <cmath>

namespace fringetwin::compare {
namespace {

using measure::Measurement;
using report::Json;

/// Makes a table whose rows are a member of Comparison.
template <class Row>
Table rows_of(const char* key, std::vector<Row> Comparison::*rows) {
  Table table{key, true, &fields<Row>, [rows](const Comparison& c) { return rows_json(c.*rows); }, nullptr};
  table.rows_of_comparison = [rows](const Comparison& c) { return row_addresses(c.*rows); };
  return table;
}

/// Makes the same, which a measurement writes without rows.
template <class Row>
Table rows_or_none(const char* key, std::vector<Row> Comparison::*rows) {
  Table table = rows_of(key, rows);
  table.of_measurement = [](const Measurement&) { return Json::array(); };
  return table;
}

/// Makes the table a section of the page.
Table shown(Table table, const char* heading, const char* caption) {
  table.heading = heading, table.caption = caption;
  return table;
}

BudgetVerdict budget_verdict(const Comparison& c) {
  const auto of = [&c](const char* quantity) -> std::string {
    const std::optional<bool> all = all_explained(c.explained, quantity);
    return !all ? "" : *all ? "explained" : "not explained";
  };
  return {of("gray"), of("phase"), of("geometry")};
}

std::vector<DecodeRow> decode_rows(const Measurement& m) {
  std::vector<DecodeRow> rows;
  for (const auto& camera : m.cameras)
    for (const auto& d : camera.directions) {
      std::uint64_t valid = 0;
      for (const double x : d.coordinate_px.data) valid += std::isfinite(x) ? 1 : 0;
      rows.push_back(
          {camera.camera, axis_name(d.axis), valid, d.repair.n_checked, d.repair.n_changed, d.repair.n_left});
    }
  return rows;
}

std::vector<Table> make_tables() {
  using Summary = measure::TriangulationSummary;
  return {
      rows_of("indicators", &Comparison::indicators),
      {"decode", true, &fields<DecodeRow>, nullptr,
       [](const Measurement& m) { return rows_json(decode_rows(m)); }},
      {"triangulation", false, &fields<Summary>, nullptr,
       [](const Measurement& m) { return row_json(m.triangulation); }},
      rows_or_none("gain", &Comparison::gain),
      shown(rows_or_none("gray", &Comparison::gray), "Gray differences per image",
            "(gain · E + black level) − real gray value, per image."),
      rows_of("gray_budget", &Comparison::gray_budget),
      rows_or_none("phase", &Comparison::phase),
      rows_of("phase_budget", &Comparison::phase_budget),
      rows_of("noise", &Comparison::noise),
      rows_of("shift", &Comparison::shift),
      {"refinement", false, &fields<Refinement>,
       [](const Comparison& c) { return c.refinement ? row_json(*c.refinement) : Json(nullptr); }, nullptr},
      {"budget_verdict", false, &fields<BudgetVerdict>,
       [](const Comparison& c) { return row_json(budget_verdict(c)); }, nullptr},
      rows_of("explained", &Comparison::explained),
      {"causes", false, &fields<Causes>, [](const Comparison& c) { return row_json(c.causes); }, nullptr},
      rows_or_none("limits", &Comparison::limits)};
}

}  // namespace

const std::vector<Table>& tables() {
  static const std::vector<Table> all = make_tables();
  return all;
}

}  // namespace fringetwin::compare
