// SPDX-License-Identifier: Apache-2.0
// Geometry indicators on the page.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "compare/page/report_parts.hpp"
#include "report/table.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

using report::text_column;

const std::map<std::string, const char*>& meanings() {
  static const std::map<std::string, const char*> all{
      {"sphere_form", "sphere form: range of the deviations"},
      {"sphere_form_95", "sphere form: range that holds 95 % of them"},
      {"sphere_size", "sphere size: diameter − nominal"},
      {"plane_flatness", "plane flatness: range of the deviations"},
      {"plane_flatness_95", "plane flatness: range that holds 95 % of them"},
      {"sphere_spacing", "sphere spacing: distance of the centres − nominal"}};
  return all;
}

std::string text(const Indicator::Value& v) {
  if (!std::isfinite(v.mm)) return "–";
  return v.sigma_mm > 0.0 ? report::with_sigma(v.mm, v.sigma_mm) : report::fixed(v.mm, 4);
}

}  // namespace

std::string indicators_html(const Comparison& c) {
  if (c.indicators.empty()) return "";
  report::Table table;
  table.caption =
      "Indicators like those of VDI/VDE 2634 part 2, of the points used in the fits. No test by that "
      "standard: one position of the objects, and the nominal values are the twin's, not those of a "
      "calibrated artefact. A range over all points grows with their number.";
  table.columns = {text_column("indicator"), text_column("object"),      {"simulated", "mm"},
                   {"real", "mm"},           {"simulated − real", "mm"}, {"z"}};
  for (const Indicator& i : c.indicators)
    table.add_row({meanings().at(i.name), fmt::format("{}", fmt::join(i.objects, " – ")), text(i.simulated),
                   text(i.real), report::signed_fixed(i.difference_mm(), 4), report::signed_fixed(i.z(), 1)});
  return table.html();
}

}  // namespace fringetwin::compare
