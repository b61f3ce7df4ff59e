// SPDX-License-Identifier: Apache-2.0
// Shift between real and simulated images: table and one map per component.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/page/report_parts.hpp"
#include "report/map.hpp"
#include "report/table.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

using report::fixed;
using report::text_column;

void add_component(report::Table& table, const ShiftRow& row, const char* name, const ShiftComponent& c) {
  table.add_row({row.camera, name, c.n_blocks == 0 ? "–" : report::with_sigma(c.mean_px, c.mean_sigma_px),
                 fixed(c.rms_px, 4), fixed(c.largest_px, 4), report::count(c.n_blocks),
                 report::number(row.chi2_before, 3), report::number(row.chi2_after, 3)});
}

std::string shift_table_html(const std::vector<ShiftRow>& rows) {
  report::Table table;
  table.caption = "The simulated image moved by (dx, dy) lies on the real one; over blocks of 32 × 32 px.";
  table.columns = {text_column("camera"),    text_column("component"),
                   {"mean", "px"},           {"rms", "px"},
                   {"largest", "px"},        {"blocks"},
                   {"χ² before", "per dof"}, {"χ² after", "per dof"}};
  for (const ShiftRow& row : rows) {
    add_component(table, row, "dx", row.dx);
    add_component(table, row, "dy", row.dy);
  }
  return table.html() +
         "<p>Only fringes tell a shift; along the fringes of one direction nothing is known (“–”), and it is "
         "taken as 0 there. One common shift points at the pose of camera or projector, one that grows over "
         "the image at the focal length or the distance, a pattern at distortion or shape. Here and on the "
         "map a fringe that the projector throws elsewhere looks the same as a camera that looks elsewhere. "
         "χ² after far above 1: the shift is not what differs.</p>";
}

}  // namespace

std::string shift_html(const ReportInput& in) {
  const std::vector<ShiftRow>& rows = in.comparison.shift;
  if (std::ranges::none_of(rows, [](const ShiftRow& r) { return r.dx.n_blocks + r.dy.n_blocks > 0; }))
    return "";
  std::string html = shift_table_html(rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ShiftRow& row = rows[i];
    const Window window = shown_part(in, camera_index(in, row.camera)).window;
    std::string maps;
    for (const auto& [name, blocks, n] :
         {std::tuple{"dx", &row.dx_px, row.dx.n_blocks}, std::tuple{"dy", &row.dy_px, row.dy.n_blocks}}) {
      if (n == 0) continue;
      report::MapStyle style{.scale = report::Scale::diverging,
                             .limits = report::symmetric_limits(*blocks),
                             .unit = "px",
                             .title = std::string(name) + ", simulated to real",
                             .max_width_px = 480};
      maps += report::map_html(crop(enlarged_blocks(*blocks, kShiftBlock), window), style);
    }
    if (!maps.empty())
      html +=
          figure_html(in, "<div class=\"maps\">" + maps + "</div>",
                      fmt::format("{}: shift that takes the simulated image onto the real one, per block; "
                                  "gray where unknown ({}).",
                                  row.camera, window.text()),
                      "minimise Σ (d − dx ∂p/∂x − dy ∂p/∂y)² / variance,  d = p − DN_real,  p = gain · E + "
                      "black_level");
  }
  return html;
}

}  // namespace fringetwin::compare
