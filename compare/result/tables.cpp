// SPDX-License-Identifier: Apache-2.0
#include "compare/result/tables.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace fringetwin::compare {
namespace {

using measure::Measurement;
using report::Json;

template <class T>
inline constexpr bool kMayBeAbsent = false;
template <class T>
inline constexpr bool kMayBeAbsent<std::optional<T>> = true;

/// Collects the tables of a comparison, which the describe() of their structs puts in the order of
/// result.json.
class TableList {
 public:
  /// Adds a table whose rows are a member of Comparison.
  template <class Row, class Tables>
  Table& rows(const char* key, std::vector<Row> Tables::*rows) {
    return all_.emplace_back(
        Table{.key = key,
              .fields = &fields<Row>,
              .of_comparison = [rows](const Comparison& c) { return rows_json(c.*rows); },
              .rows_of_comparison = [rows](const Comparison& c) { return row_addresses(c.*rows); }});
  }
  /// Adds a table that is a single row, which may be absent.
  template <class Get>
  Table& row(const char* key, Get get) {
    using Value = std::decay_t<std::invoke_result_t<Get, const Comparison&>>;
    Table& table = all_.emplace_back(Table{.key = key, .is_list = false});
    if constexpr (kMayBeAbsent<Value>) {
      table.fields = &fields<typename Value::value_type>;
      table.of_comparison = [get](const Comparison& c) {
        const Value& value = std::invoke(get, c);
        return value ? row_json(*value) : Json(nullptr);
      };
    } else {
      table.fields = &fields<Value>;
      table.of_comparison = [get](const Comparison& c) { return row_json(std::invoke(get, c)); };
    }
    return table;
  }
  void add(Table table) { all_.push_back(std::move(table)); }
  std::vector<Table> take() { return std::move(all_); }

 private:
  std::vector<Table> all_;
};

/// How many pixels of one camera and direction a measurement decoded, and what the repair of fringe orders
/// did.
struct DecodeRow {
  std::string camera, direction;
  std::uint64_t n_valid = 0, orders_checked = 0, orders_changed = 0, orders_left = 0;

  static void describe(auto& f) {
    using Row = DecodeRow;
    f.name("camera", "camera of the twin", &Row::camera);
    f.name("direction", "direction of the fringes", &Row::direction).one_of({"x", "y"});
    f.add("n_valid", "pixels with a coordinate", &Row::n_valid);
    f.add("orders_checked", "pixels whose fringe order was held against their neighbours",
          &Row::orders_checked)
        .not_required();
    f.add("orders_changed", "of these, moved by a whole period", &Row::orders_changed).not_required();
    f.add("orders_left", "jumps that remain between neighbours", &Row::orders_left).not_required();
  }
};

std::vector<DecodeRow> decode_rows(const Measurement& m) {
  std::vector<DecodeRow> rows;
  for (const auto& camera : m.cameras)
    for (const auto& d : camera.directions) {
      const std::vector<double>& x = d.coordinate_px.data;
      const auto valid = std::ranges::count_if(x, [](double v) { return std::isfinite(v); });
      rows.push_back({camera.camera, axis_name(d.axis), static_cast<std::uint64_t>(valid), d.repair.n_checked,
                      d.repair.n_changed, d.repair.n_left});
    }
  return rows;
}

/// What became of the pixels that were triangulated.
struct TriangulationRow : measure::TriangulationSummary {
  static void describe(auto& f) {
    using Row = TriangulationRow;
    f.add("n_candidates", "valid pixels of the first camera that were tried", &Row::n_candidates)
        .not_required();
    f.add("n_points", "points found", &Row::n_points).not_required();
    f.add("n_no_match", "pixels whose coordinate or surface the second image does not have", &Row::n_no_match)
        .not_required();
    f.add("n_ambiguous", "pixels with several matches", &Row::n_ambiguous).not_required();
    f.add("n_rejected", "pixels whose point was refused", &Row::n_rejected).not_required();
    f.add("n_mixed", "border pixels that were not tried", &Row::n_mixed).not_required();
  }
};

std::vector<Table> make_tables() {
  TableList all;
  GeometryTables::describe(all);
  all.add({.key = "decode", .fields = &fields<DecodeRow>, .of_measurement = [](const Measurement& m) {
             return rows_json(decode_rows(m));
           }});
  all.add(
      {.key = "triangulation",
       .is_list = false,
       .fields = &fields<TriangulationRow>,
       .of_measurement = [](const Measurement& m) { return row_json(TriangulationRow{m.triangulation}); }});
  // without rows there is no such table: results are the same where nobody asked for it
  const auto rows_or_none = [](const std::vector<LightRow>& rows) {
    return rows.empty() ? Json(nullptr) : rows_json(rows);
  };
  all.add({.key = "light",
           .fields = &fields<LightRow>,
           .of_comparison = [=](const Comparison& c) { return rows_or_none(c.light); },
           .of_measurement =
               [=](const Measurement& m) {
                 std::vector<LightRow> rows;
                 add_light_rows(m, "", rows);
                 return rows_or_none(rows);
               }});
  GrayTables::describe(all);
  all.add({.key = "held_out",
           .fields = &fields<HeldOutRow>,
           .of_comparison =
               [](const Comparison& c) { return c.held_out.empty() ? Json(nullptr) : rows_json(c.held_out); },
           .heading = "Held-out images",
           .caption =
               "Predicted − real gray value of images that took no part in the fit: the twin was fitted "
               "to the phase steps of the other folds.",
           .rows_of_comparison = [](const Comparison& c) { return row_addresses(c.held_out); }});
  PhaseTables::describe(all);
  BlockTables::describe(all);
  CoverageTables::describe(all);
  all.add({.key = "other_surfaces",
           .fields = &fields<OtherSurfaceRow>,
           .of_comparison =
               [](const Comparison& c) {
                 return c.other_surfaces.empty() ? Json(nullptr) : rows_json(c.other_surfaces);
               },
           .heading = "Other surfaces",
           .caption = "Connected areas in which the real images show another surface than the twin.",
           .rows_of_comparison = [](const Comparison& c) { return row_addresses(c.other_surfaces); }});
  VerdictTables::describe(all);
  return all.take();
}

}  // namespace

Table& Table::in_measurements() {
  of_measurement = [](const Measurement&) { return Json::array(); };
  return *this;
}

Table& Table::shown(const char* its_heading, const char* its_caption) {
  heading = its_heading, caption = its_caption;
  return *this;
}

const std::vector<Table>& tables() {
  static const std::vector<Table> all = make_tables();
  return all;
}

}  // namespace fringetwin::compare
