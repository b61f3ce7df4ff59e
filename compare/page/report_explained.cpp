// SPDX-License-Identifier: Apache-2.0
// Verdicts against the budget, the budget as bars, likely causes, refined values.
#include <fmt/format.h>

#include <cmath>

#include "compare/causes/causes.hpp"
#include "compare/page/field_table.hpp"
#include "compare/page/report_parts.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/pattern/pattern.hpp"
#include "compare/verdict/explained.hpp"
#include "report/map.hpp"
#include "report/table.hpp"
#include "report/text.hpp"
#include "report/words.hpp"

namespace fringetwin::compare {
namespace {

using report::fixed;
using report::number;
using report::text_column;

std::string chi2_text(double chi2, double limit) {
  return std::isfinite(chi2) ? fmt::format("{} (≤ {})", number(chi2, 3), number(limit, 3)) : "–";
}

std::string rms_text(double variance, const std::string& unit) {
  if (!std::isfinite(variance)) return "–";
  const double rms = std::sqrt(std::max(0.0, variance));
  return unit == "mm" ? number(1000.0 * rms, 3) + " µm" : number(rms, 3) + " " + unit;
}

/// Draws the expected variance as bars, one line each, the observed one above them.
std::string bars_html(const ExplainedRow& row) {
  const double scale = 100.0 / std::max(row.expected(), row.observed);
  const auto bar = [&](const std::string& name, double variance, const char* css) {
    return fmt::format(
        "<tr><td class=\"l\">{}</td><td class=\"r\">{}</td><td class=\"r\">{} %</td><td "
        "class=\"share\"><span class=\"{}\" style=\"width:{:.2f}%\"></span></td></tr>",
        report::escape_html(name), rms_text(variance, row.unit), fixed(100.0 * variance / row.expected(), 1),
        css, std::max(0.0, scale * variance));
  };
  std::string html = fmt::format(
      "<table><caption>{}, {}{}</caption><tr><th class=\"l\">part</th><th "
      "class=\"r\">standard uncertainty</th><th class=\"r\">of the expected variance</th><th></th></tr>",
      row.quantity, report::escape_html(row.region),
      row.worst.empty() ? "" : ": " + report::escape_html(row.worst));
  for (const BudgetLine& line : row.lines) html += bar(line.name, line.variance, "part");
  html += bar("expected in all", row.expected(), "whole");
  html += bar("observed", row.observed, row.explained() ? "whole" : "beyond");
  return report::table_box_html("uncertainty budget of " + row.quantity, html + "</table>", "budget");
}

/// Returns the sentences on the rows' states, where there are any.
std::string reasons_html(const std::vector<ExplainedRow>& rows) {
  std::string html;
  for (const ExplainedRow& row : rows)
    if (!row.why.empty())
      html += fmt::format("<p>{} {}, {}: {}.</p>", row.quantity, report::escape_html(row.region),
                          report::word_html(row.state), report::escape_html(row.why));
  return html;
}

std::string map_of_regions(const ExplainedRow& row) {
  if (row.regions.empty()) return "";
  report::MapStyle style{.limits = {0.0, std::max(2.0, report::percentile(row.regions.data, 98.0))},
                         .unit = "χ² per region",
                         .title = "chi2 of regions"};
  return titled_map(
      fmt::format("{} {}: χ² of regions of 16 × 16 px", row.quantity, report::escape_html(row.region)),
      report::map_html(row.regions, style));
}

}  // namespace

std::string explained_summary_html(const Comparison& c) {
  if (c.explained.empty()) return "";
  report::Table table;
  table.caption =
      "Is the difference as large as the stated budget allows? χ² over single values, and over means of "
      "regions, where noise averages out; 1 is expected.";
  table.columns = {text_column("quantity"), text_column("where"), {"observed", "rms"}, {"expected", "rms"},
                   {"χ² of values"},        {"χ² of regions"},    {"verdict"}};
  for (const ExplainedRow& row : c.explained)
    table.add_row(
        {row.quantity, row.worst.empty() ? row.region : row.region + ", " + row.worst,
         rms_text(row.observed, row.unit), rms_text(row.expected(), row.unit),
         chi2_text(row.chi2, row.chi2_limit), chi2_text(row.regional_chi2, row.regional_limit), row.state},
        row.explained() ? "pass" : "fail");
  std::string html = table.html() + reasons_html(c.explained);
  for (const std::string& line :
       {sentence(c.causes), pattern_sentence(c.causes.pattern), gain_sentence(c.causes)})
    if (!line.empty()) html += "<p><strong>" + report::escape_html(line) + ".</strong></p>";
  return html;
}

std::string explained_html(const Comparison& c) {
  if (c.explained.empty()) return "";
  std::string html, maps;
  for (const ExplainedRow& row : c.explained)
    if (!row.lines.empty()) html += bars_html(row);
  for (const ExplainedRow& row : c.explained) maps += map_of_regions(row);
  if (!maps.empty())
    html += "<figure><div class=\"maps\">" + maps +
            "</div><figcaption>Where the difference exceeds the budget. Regions with fewer than 64 interior "
            "pixels are left out.</figcaption></figure>";
  return html;
}

std::string causes_html(const Comparison& c) {
  if (c.causes.rows.empty()) return "";
  report::Table table;
  table.caption = fmt::format(
      "χ² per gray value is {} after gain and black level; what exceeds 1 is split here. Each cause is "
      "fitted to the gray values of all cameras (n = {}); “after those above” counts only what is left.",
      number(c.causes.chi2, 4), report::count(c.causes.n));
  table.columns = {text_column("the twin may be wrong about"),
                   {"explains alone", "% of the excess"},
                   {"after those above", "%"},
                   text_column("parameter"),
                   {"twin"},
                   {"would fit"}};
  for (const CauseRow& row : c.causes.rows) {
    std::string cause = row.cause, alone = fixed(100.0 * row.alone, 1),
                in_order = row.order > 0 ? fixed(100.0 * row.in_order, 1) : "–";
    const bool many = row.order == 0 && row.parameters.size() > 3;
    if (row.parameters.empty()) table.add_row({cause, alone, in_order, "", "", ""});
    for (const CauseParameter& p : row.parameters) {
      const std::string unit = p.unit.empty() ? "" : " " + p.unit;
      table.add_row(
          {cause, alone, in_order, many ? fmt::format("{} parameters", row.parameters.size()) : p.name,
           many ? "" : number(p.twin, 6) + unit, many ? "" : report::with_sigma(p.estimate, p.sigma) + unit});
      if (many) break;
      cause = alone = in_order = "";  // once for all parameters
    }
  }
  std::string html = table.html();
  if (std::isfinite(c.causes.rest))
    html += fmt::format("<p>Left by the causes taken in order: {} % of the excess.</p>",
                        fixed(100.0 * std::max(0.0, c.causes.rest), 1));
  return html;
}

std::string refinement_html(const Comparison& c) {
  if (!c.refinement) return "";
  const Refinement& r = *c.refinement;
  report::Table table = field_table(r.rows);
  table.caption = fmt::format(
      "Fitted to the real gray values of all phase steps before this comparison ({} steps{}): χ² per gray "
      "value {} → {} (n = {}). Standard errors contain noise and what is left, as blocks of pixels and "
      "images scatter by it.",
      r.iterations, r.converged ? "" : ", NOT CONVERGED", number(r.chi2_before, 4), number(r.chi2_after, 4),
      report::count(r.n));
  std::string html = table.html();
  for (const std::string& note : r.notes) html += "<p>" + report::escape_html(note) + ".</p>";
  return html + "<p>The values are in refined.toml beside this page.</p>";
}

}  // namespace fringetwin::compare
