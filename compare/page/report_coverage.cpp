// SPDX-License-Identifier: Apache-2.0
// Makes the page's section on coverage: how many pixels each side measured, and a map per camera of those
// that one side alone measured.
#include <fmt/format.h>

#include <limits>

#include "compare/page/field_table.hpp"
#include "compare/page/report_parts.hpp"
#include "compare/verdict/coverage.hpp"
#include "report/map.hpp"
#include "report/table.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

std::string coverage_table_html(const std::vector<CoverageRow>& rows) {
  report::Table table = field_table(rows);
  table.caption =
      "Pixels that both sides measured, one side alone, or neither, of all that have fringes or are "
      "saturated on a side. Inside: away from the outlines; thick: more than 2 px inside an area that one "
      "side alone measured.";
  table.columns.push_back({"verdict"});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].object.empty()) table.rows[i].cells[1] = "all";
    table.rows[i].cells.emplace_back(rows[i].explained ? "explained" : "not explained");
    table.rows[i].css_class = rows[i].explained ? "pass" : "fail";
  }
  std::string html = table.html();
  for (const CoverageRow& row : rows)
    if (!row.why.empty())
      html += fmt::format("<p>{}{}: {}.</p>\n", report::escape_html(row.camera),
                          row.object.empty() ? "" : ", " + report::escape_html(row.object),
                          report::escape_html(row.why));
  return html;
}

std::string coverage_figure_html(const ReportInput& in, const std::string& camera) {
  const std::size_t c = camera_index(in, camera);
  const ImageF map = coverage_map(pixel_states(in.twin, c, in.real), pixel_states(in.twin, c, in.simulated));
  const report::MapStyle style{.scale = report::Scale::diverging,
                               .limits = {-1.0, 1.0},
                               .title = "real only (-1), both (0), simulated only (1)",
                               .max_width_px = 720};
  const std::string file = "coverage_" + camera + ".png";
  report::write_map_png(in.dir / file, map, style);
  const Window window = data_window(finite_mask(map));
  return figure_html(
      in, "<div class=\"maps\">" + report::map_html(crop(map, window), style) + "</div>",
      fmt::format("{}, {}: where one side alone measured: −1 (blue) the real side, 1 (red) the "
                  "simulated side, 0 (white) both; gray: neither; hatched: saturated. Full "
                  "resolution: {}.",
                  camera, window.text(), file));
}

}  // namespace

ImageF coverage_map(const Image<PixelState>& real, const Image<PixelState>& simulated) {
  constexpr int kStripe = 4;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  ImageF map(real.width, real.height);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const PixelState r = real(x, y), s = simulated(x, y);
      const bool on_real = r == PixelState::measured, on_simulated = s == PixelState::measured;
      const bool saturated = r == PixelState::saturated || s == PixelState::saturated;
      const bool stripe = saturated && (x + y) / kStripe % 2 == 0;
      const float value = on_real && on_simulated   ? 0.0F
                          : on_real || on_simulated ? (on_real ? -1.0F : 1.0F)
                                                    : kNone;
      map(x, y) = !stripe ? value : on_real || on_simulated ? kNone : 0.0F;
    }
  return map;
}

std::string coverage_html(const ReportInput& in) {
  const std::vector<CoverageRow>& rows = in.comparison.coverage;
  if (rows.empty()) return "";
  std::string html = coverage_table_html(rows);
  for (const CoverageRow& row : rows)
    if (row.object.empty()) html += coverage_figure_html(in, row.camera);
  return html;
}

}  // namespace fringetwin::compare
