// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "compare/page/field_table.hpp"
#include "compare/page/report_parts.hpp"
#include "compare/result/fit_keys.hpp"
#include "compare/verdict/limits.hpp"
#include "report/table.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

using measure::ObjectFit;
using report::fixed;
using report::number;
using report::signed_fixed;
using report::text_column;

/// A scalar of one side with its standard error.
struct Entry {
  double value = kNaN, sigma = kNaN;
};

/// Returns a number (component < 0) or the component of a vector; NaN where there is none.
double value_of(const std::map<std::string, double>& numbers,
                const std::map<std::string, Eigen::Vector3d>& vectors, const std::string& key,
                int component) {
  if (component < 0) return value_or(numbers, key, kNaN);
  return value_or(vectors, key, Eigen::Vector3d::Constant(kNaN))[component];
}

Entry entry(const std::optional<ObjectFit>& fit, const std::string& key, int component) {
  if (!fit || !fit->usable) return {};
  return {value_of(fit->numbers, fit->vectors, key, component),
          value_of(fit->numbers, fit->vectors, sigma_key(key), component)};
}

std::string entry_text(const Entry& e, const std::string& unit) {
  if (!std::isfinite(e.value)) return "–";
  if (std::isfinite(e.sigma) && e.sigma > 0.0) return report::with_sigma(e.value, e.sigma);
  return fixed(e.value, unit == "mm" ? 4 : 6);
}

/// Tenths of a micrometre are enough for a difference, unless it is smaller than one itself.
std::string difference_text(double difference, const std::string& unit) {
  return signed_fixed(difference, unit == "mm" && std::abs(difference) >= 1e-3 ? 4 : 6);
}

void add_fit_row(report::Table& table, const FitRow& row, const std::string& key, int component,
                 bool estimates) {
  auto [name, unit] = name_and_unit(key);
  if (component >= 0) name += fmt::format(" {}", "xyz"[component]);
  const Entry s = entry(row.simulated, key, component), r = entry(row.real, key, component);
  const double difference = s.value - r.value;
  std::vector<std::string> cells{name,
                                 unit,
                                 entry_text(s, unit),
                                 entry_text(r, unit),
                                 difference_text(difference, unit),
                                 signed_fixed(value_of(row.z, row.z_vectors, key, component), 1)};
  if (estimates)
    cells.push_back(signed_fixed(value_of(row.z_estimated, row.z_estimated_vectors, key, component), 1));
  table.add_row(std::move(cells));
}

/// Returns the fits of the sides that have one.
std::vector<const ObjectFit*> fits_of(const FitRow& row) {
  std::vector<const ObjectFit*> fits;
  for (const auto* fit : {&row.simulated, &row.real})
    if (*fit) fits.push_back(&**fit);
  return fits;
}

/// Returns the keys that the fits have in `values`, sigmas and directions left out.
template <class Values>
std::vector<std::string> keys_of(const std::vector<const ObjectFit*>& fits, Values ObjectFit::*values) {
  std::vector<std::string> keys;
  for (const ObjectFit* fit : fits)
    for (const auto& [key, value] : fit->*values)
      if (!is_sigma_key(key) && !is_direction_key(key) && std::ranges::find(keys, key) == keys.end())
        keys.push_back(key);
  return keys;
}

/// One part of a mean square.
struct Part {
  std::string name, what;
  double square = 0.0;
};

/// Adds what one factor per pixel removes of a gray budget: of that what the noise of a measured shape
/// predicts stands by itself, for it is no reflectivity of the part.
void add_factor_parts(const GrayBudget& b, std::vector<Part>& parts) {
  const std::string what = fmt::format("removed by one factor per pixel on gain · E (robust spread {} %)",
                                       number(100.0 * b.albedo_sigma, 3));
  if (!(b.shading_dn2 > 0.0)) return parts.push_back({"albedo, shading", what, b.albedo_dn2});
  parts.push_back({"shading by the shape's noise",
                   "predicted from the noise of the depth map that the shape was built from: no reflectivity "
                   "of the part",
                   b.shading_dn2});
  parts.push_back({"albedo, other shading", what + ", but for the line above", b.albedo_dn2 - b.shading_dn2});
}

/// Tabulates the parts with their roots and their shares of the last one, the total. `columns`: what the
/// square and its root are; `text`: prints a square; `digits`: of a root.
template <class Text>
report::Table part_table(const std::string& caption, const report::Column& square, const report::Column& root,
                         const std::vector<Part>& parts, Text text, int digits) {
  report::Table table;
  table.caption = caption;
  table.columns = {text_column("part"), text_column("what it is"), square, root, {"share", "%"}};
  const double total = parts.back().square;
  for (const Part& p : parts)
    table.add_row({p.name, p.what, text(p.square), p.square >= 0.0 ? fixed(std::sqrt(p.square), digits) : "–",
                   total > 0.0 ? fixed(100.0 * p.square / total, 1) : "–"},
                  p.name == "total" ? "total" : "");
  return table;
}

}  // namespace

std::pair<std::string, std::string> name_and_unit(const std::string& key) {
  if (const Field* field = find_field(fit_fields(), key); field && field->column)
    return {field->column->header, field->column->unit};
  for (const char* unit : {"mm", "rad", "px", "dn"})
    if (key.ends_with(std::string("_") + unit))
      return {key.substr(0, key.size() - std::string(unit).size() - 1), unit};
  return {key, ""};
}

std::string fit_value_text(const std::optional<ObjectFit>& fit, const std::string& key, int component) {
  return entry_text(entry(fit, key, component), name_and_unit(key).second);
}

std::vector<std::string> vector_keys(const std::vector<const ObjectFit*>& fits) {
  return keys_of(fits, &ObjectFit::vectors);
}

std::vector<std::string> number_keys(const std::vector<const ObjectFit*>& fits) {
  std::vector<std::string> keys = keys_of(fits, &ObjectFit::numbers);
  std::erase_if(keys, is_count_key);
  const auto is_rms = [](const std::string& key) { return key == "rms_mm" || key == "rms_all_mm"; };
  if (std::erase_if(keys, is_rms) > 0) keys.insert(keys.end(), {"rms_mm", "rms_all_mm"});
  return keys;
}

std::string points_text(const std::optional<ObjectFit>& fit) {
  if (!fit) return "–";
  if (fit->n == 0) return fit->usable ? "published" : "0";
  const auto gated = fit->numbers.find("n_gated");
  const std::string of = gated == fit->numbers.end()
                             ? ""
                             : " of " + report::count(static_cast<unsigned long long>(gated->second));
  return report::count(fit->n) + of + (fit->usable ? "" : " (no fit)");
}

std::string verdict_html(const Comparison& c) {
  if (c.limits.empty())
    return "<p>No acceptance limits are set in the twin (<code>[limits]</code>): nothing was judged here. "
           "The key <code>verdict</code> of result.json says \"pass\" because no limit is broken.</p>";
  report::Table table;
  table.columns = {text_column("quantity"), text_column("meaning"), {"value"}, {"limit"}, {"verdict"}};
  for (const LimitRow& row : c.limits) {
    const Limit& limit = limits_by_name().at(row.name);
    table.add_row(
        {row.name, limit.meaning, number(row.value, 4),
         fmt::format("{} {:.6g}", limit.is_least() ? "≥" : "≤", row.limit), row.pass ? "pass" : "fail"},
        row.pass ? "pass" : "fail");
  }
  return table.html();
}

std::string fits_html(const ReportInput& in) {
  if (in.comparison.fits.empty()) return "";
  report::Table table;
  table.caption =
      "Values with one standard error where it is known; z = difference / combined standard error. Fits "
      "leave out points beyond four robust residual scales.";
  table.columns = {
      text_column("quantity"), text_column("unit"), {"simulated"}, {"real"}, {"simulated − real"}, {"z"}};
  bool estimates = false;
  for (const FitRow& row : in.comparison.fits)
    estimates = estimates || !row.z_estimated.empty() || !row.z_estimated_vectors.empty();
  if (estimates) table.columns.push_back({"z (σ of the real side estimated from its rms)"});
  for (const FitRow& row : in.comparison.fits) {
    table.add_row({fmt::format("{} ({})", row.object, row.kind)}, "group");
    for (const std::string& key : vector_keys(fits_of(row)))
      for (int i = 0; i < 3; ++i) add_fit_row(table, row, key, i, estimates);
    for (const std::string& key : number_keys(fits_of(row))) add_fit_row(table, row, key, -1, estimates);
    for (const char* key : {"offset_mm", "tilt_rad_0", "tilt_rad_1", "angle_rad", "axis_distance_mm",
                            "axis_rad_0", "axis_rad_1", "axis_shift_mm_0", "axis_shift_mm_1"})
      if (const double* difference = find_value(row.difference, key)) {
        const auto [name, unit] = name_and_unit(key);
        table.add_row({name, unit, "", "", difference_text(*difference, unit),
                       signed_fixed(value_or(row.z, key, kNaN), 1)});
      }
    table.add_row({"points used, of those within the gate", "", points_text(row.simulated),
                   points_text(row.real), "", ""});
  }
  std::string html = table.html();
  for (const FitRow& row : in.comparison.fits)
    html +=
        fmt::format("<p>Alignment of “{}”: {}.</p>", report::escape_html(row.object), alignment_of(row.kind));
  if (!in.twin.real.results.empty() && !in.real.measurement)
    html += "<p>Real: published numbers" +
            (in.twin.real.results_source.empty() ? std::string()
                                                 : ", " + report::escape_html(in.twin.real.results_source)) +
            ". No real images exist for this twin.</p>";
  if (estimates)
    html +=
        "<p>The published numbers come without standard errors, so z is unknown. The last column estimates "
        "them from the published rms, as if the real points were the simulated ones and their errors "
        "independent: true errors are correlated, so the true z is nearer to zero.</p>";
  return html;
}

std::string gain_table_html(const Comparison& c) {
  if (c.gain.empty()) return "";
  report::Table table = field_table(c.gain);
  table.caption =
      "DN = gain · E + black level, Huber fit over all usable gray values of the phase steps; before = the "
      "twin's own sensor values. Where the twin gives a camera a response that is not straight, the gray "
      "values have been straightened by its inverse, and the gain is its slope at the origin.";
  return table.html() +
         "<p>σ inflation is the standard error of the gain with spatial correlation (blocks of 32 × 32 px, "
         "all images of a block together) over the one for independent gray values. Far above 1 means that "
         "the residuals are correlated: shape, albedo or shading rather than noise. The printed σ are "
         "widened by what parts of the gray values disagree with the line by (below): albedo, shading or "
         "ambient light that varies over the image biases gain and black level. Gain, projector intensity "
         "and diffuse albedo enter only as a product: intensity and albedo are held at the twin's "
         "values.</p>";
}

std::string budget_html(const Comparison& c) {
  std::string html;
  for (const GrayBudget& b : c.gray_budget) {
    std::vector<Part> parts{{"noise", "predicted: " + b.noise_source, b.noise_dn2}};
    add_factor_parts(b, parts);
    parts.insert(
        parts.end(),
        {{"fringe contrast", "removed by a common offset and fundamental of the phase", b.contrast_dn2},
         {"projector harmonics", "removed by common orders 2…6 of the phase", b.higher_orders_dn2},
         {"geometry", "removed by one shift of the projector coordinate per pixel", b.geometry_dn2},
         {"rest", "not explained by the above", b.rest_dn2},
         {"total", "", b.total_dn2}});
    html += part_table(
                fmt::format(
                    "Camera {}: variance of real − fitted gray values, split (n = {} values of {} pixels)",
                    b.camera, report::count(b.n), report::count(b.n_pixels)),
                {"variance", "DN²"}, {"rms", "DN"}, parts, [](double v) { return fixed(v, 4); }, 3)
                .html();
    std::string orders;
    for (std::size_t k = 0; k < b.harmonic_amplitude.size(); ++k)
      orders += fmt::format("{}{}: {} %", k == 0 ? "" : ", ", k, number(100.0 * b.harmonic_amplitude[k], 3));
    html +=
        "<p>Amplitude of the common periodic residual by order, relative to the local gray level above "
        "black: " +
        orders + ".";
    if (50.0 * b.noise_per_dn > 0.05 * b.noise_offset_dn2)  // a slope worth a number
      html += fmt::format(" Noise line: variance = {} + {} · DN (about {} electrons per DN).",
                          number(b.noise_offset_dn2, 3), number(b.noise_per_dn, 3),
                          number(1.0 / b.noise_per_dn, 3));
    html += "</p>\n";
  }
  return html;
}

std::string phase_table_html(const Comparison& c) {
  if (c.phase.empty()) return "";
  report::Table table = field_table(c.phase);
  table.caption = "Absolute phase at the finest pitch, simulated − real, where both are valid.";
  return table.html();
}

std::string phase_budget_html(const Comparison& c) {
  std::string html;
  for (const PhaseBudget& b : c.phase_budget) {
    const report::Table table = part_table(
        fmt::format("Camera {}, direction {}: mean square of the phase difference, split (n = {})", b.camera,
                    b.direction, report::count(b.n)),
        {"mean square", "rad²"}, {"rms", "rad"},
        {{"offset", "square of the mean difference", b.offset_rad2},
         {"brightness",
          "ripple of order 1 and 2 of the phase, which brightness changes between the step images leave",
          b.brightness_rad2},
         {"harmonics",
          fmt::format("ripple of order {0} and {1} of the phase, which projector harmonics {2} and {3} leave "
                      "in the steps used (amplitude of order {0}: {4} rad)",
                      b.alias_order, 2 * b.alias_order, b.alias_order - 1, b.alias_order + 1,
                      number(b.harmonic_amplitude_rad, 3)),
          b.harmonic_rad2},
         {"noise", "predicted from the phase sigma of both sides", b.noise_rad2},
         {"low frequency", "means over 16 × 16 px, less their noise: shape, calibration, interreflection",
          b.low_frequency_rad2},
         {"high frequency", "the rest: texture, edges, noise beyond the prediction", b.high_frequency_rad2},
         {"total", "", b.total_rad2}},
        [](double v) { return number(v, 3); }, 4);
    html +=
        table.html() +
        fmt::format("<p>Brightness, harmonics and noise explain {} % of the variance about the mean.</p>\n",
                    fixed(100.0 * b.explained(), 1));
  }
  return html;
}

std::string timing_html(const std::map<std::string, double>& timing_s) {
  if (timing_s.empty()) return "";
  report::Table table;
  table.columns = {text_column("stage"), {"time", "s"}};
  for (const auto& [stage, seconds] : timing_s) table.add_row({stage, fixed(seconds, 3)});
  return table.html();
}

}  // namespace fringetwin::compare
