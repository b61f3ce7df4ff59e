// SPDX-License-Identifier: Apache-2.0
#include "compare/result/result_json.hpp"

#include <cmath>

#include "compare/result/fit_keys.hpp"
#include "compare/result/row_json.hpp"
#include "report/json.hpp"

namespace fringetwin::compare {
namespace {

using measure::ObjectFit;
using report::Json;
using report::json_number;

Json vector(const Eigen::Vector3d& v) {
  return Json::array({json_number(v[0]), json_number(v[1]), json_number(v[2])});
}

/// Every fit of a kind has the same keys; what is unknown is null.
Json fit_template(const std::string& kind) {
  Json fit = Json::object();
  std::vector<std::string> keys;
  if (kind == "sphere") keys = {"center_mm", "center_sigma_mm", "radius_mm", "radius_sigma_mm"};
  if (kind == "plane") keys = {"point_mm", "normal"};
  if (kind == "cylinder") keys = {"point_mm", "axis", "radius_mm", "radius_sigma_mm"};
  for (const std::string& key : keys) fit[key] = nullptr;
  fit["rms_mm"] = nullptr;
  return fit;
}

Json fit_json(const std::optional<ObjectFit>& fit) {
  if (!fit) return nullptr;
  Json out = fit_template(fit->kind);
  if (fit->usable) {
    for (const auto& [key, value] : fit->numbers)
      out[key] = is_count_key(key) && std::isfinite(value) ? Json(std::llround(value)) : json_number(value);
    for (const auto& [key, value] : fit->vectors) out[key] = vector(value);
  }
  out["n"] = fit->n;
  if (!fit->warning.empty()) out["warning"] = fit->warning;
  return out;
}

Json values_json(const std::map<std::string, double>& numbers,
                 const std::map<std::string, Eigen::Vector3d>& vectors) {
  Json out = Json::object();
  for (const auto& [key, value] : vectors) out[key] = vector(value);
  for (const auto& [key, value] : numbers) out[key] = json_number(value);
  return out.empty() ? Json(nullptr) : out;
}

Json fit_row_json(const FitRow& row) {
  Json difference = Json::object(), z = Json::object();
  for (const auto& [key, value] : row.difference_vectors) {
    difference[key] = vector(value);
    const auto at = row.z_vectors.find(key);
    z[key] = at == row.z_vectors.end() ? Json(nullptr) : vector(at->second);
  }
  for (const auto& [key, value] : row.difference) {
    difference[key] = json_number(value);
    const auto at = row.z.find(key);
    z[key] = at == row.z.end() ? Json(nullptr) : json_number(at->second);
  }
  const bool both = row.simulated && row.real;
  return {{"object", row.object},
          {"kind", row.kind},
          {"alignment", alignment_of(row.kind)},
          {"simulated", fit_json(row.simulated)},
          {"real", fit_json(row.real)},
          {"difference", both ? difference : Json(nullptr)},
          {"z", both ? z : Json(nullptr)},
          {"real_estimated", values_json(row.real_sigma_estimated, row.real_sigma_estimated_vectors)},
          {"z_estimated", values_json(row.z_estimated, row.z_estimated_vectors)}};
}

Json gain_json(const GainRow& r) {
  return {{"camera", r.camera},
          {"gain_dn", json_number(r.gain_dn)},
          {"gain_sigma_dn", json_number(r.gain_sigma_dn)},
          {"black_level_dn", json_number(r.black_level_dn)},
          {"black_level_sigma_dn", json_number(r.black_level_sigma_dn)},
          {"rms_before_dn", json_number(r.rms_before_dn)},
          {"rms_after_dn", json_number(r.rms_after_dn)},
          {"r2", json_number(r.r2)},
          {"n", r.n},
          {"sigma_inflation", json_number(r.sigma_inflation)},
          {"outlier_fraction", json_number(r.outlier_fraction)}};
}

Json gray_json(const GrayRow& r) {
  return {{"camera", r.camera},
          {"pattern", r.pattern},
          {"mean_dn", json_number(r.mean_dn)},
          {"rms_dn", json_number(r.rms_dn)},
          {"p99_dn", json_number(r.p99_dn)},
          {"n", r.n}};
}

Json budget_json(const GrayBudget& b) {
  Json harmonics = Json::array();
  for (double a : b.harmonic_amplitude) harmonics.push_back(json_number(a));
  return {{"camera", b.camera},
          {"noise_source", b.noise_source},
          {"total_dn2", json_number(b.total_dn2)},
          {"noise_dn2", json_number(b.noise_dn2)},
          {"albedo_dn2", json_number(b.albedo_dn2)},
          {"harmonics_dn2", json_number(b.harmonics_dn2)},
          {"geometry_dn2", json_number(b.geometry_dn2)},
          {"rest_dn2", json_number(b.rest_dn2)},
          {"contrast_dn2", json_number(b.contrast_dn2)},
          {"higher_orders_dn2", json_number(b.higher_orders_dn2)},
          {"noise_offset_dn2", json_number(b.noise_offset_dn2)},
          {"noise_per_dn", json_number(b.noise_per_dn)},
          {"albedo_spread", json_number(b.albedo_sigma)},
          {"harmonic_amplitude", harmonics},
          {"n_pixels", b.n_pixels},
          {"n", b.n}};
}

Json phase_json(const PhaseRow& r) {
  return {{"camera", r.camera},
          {"direction", r.direction},
          {"mean_rad", json_number(r.mean_rad)},
          {"rms_rad", json_number(r.rms_rad)},
          {"p99_rad", json_number(r.p99_rad)},
          {"mean_relative", json_number(r.mean_relative)},
          {"n", r.n},
          {"n_order_disagree", r.n_order_disagree},
          {"order_disagree_fraction", json_number(r.order_disagree_fraction())}};
}

Json phase_budget_json(const PhaseBudget& b) {
  return {{"camera", b.camera},
          {"direction", b.direction},
          {"alias_order", b.alias_order},
          {"total_rad2", json_number(b.total_rad2)},
          {"offset_rad2", json_number(b.offset_rad2)},
          {"brightness_rad2", json_number(b.brightness_rad2)},
          {"harmonic_rad2", json_number(b.harmonic_rad2)},
          {"noise_rad2", json_number(b.noise_rad2)},
          {"low_frequency_rad2", json_number(b.low_frequency_rad2)},
          {"high_frequency_rad2", json_number(b.high_frequency_rad2)},
          {"harmonic_amplitude_rad", json_number(b.harmonic_amplitude_rad)},
          {"explained_fraction", json_number(b.explained())},
          {"n", b.n}};
}

Json explained_json(const ExplainedRow& r) {
  Json lines = Json::array();
  for (const BudgetLine& line : r.lines)
    lines.push_back({{"name", line.name},
                     {"variance", json_number(line.variance)},
                     {"share", json_number(line.variance / r.expected())}});
  Json out = {{"quantity", r.quantity},
              {"region", r.region},
              {"unit", r.unit},
              {"observed", json_number(r.observed)},
              {"expected", json_number(r.expected())},
              {"budget", lines},
              {"chi2", json_number(r.chi2)},
              {"chi2_limit", json_number(r.chi2_limit)},
              {"regional_chi2", json_number(r.regional_chi2)},
              {"regional_limit", json_number(r.regional_limit)},
              {"n", r.n},
              {"n_regions", r.n_regions},
              {"explained", r.explained}};
  if (!r.worst.empty()) out["worst"] = r.worst;
  return out;
}

Json refinement_json(const Refinement& r) {
  Json rows = Json::array(), covariance = Json::array();
  for (const RefinedRow& row : r.rows)
    rows.push_back({{"name", row.name},
                    {"unit", row.unit},
                    {"before", json_number(row.before)},
                    {"after", json_number(row.after)},
                    {"after_sigma", json_number(row.sigma)}});
  for (Eigen::Index i = 0; i < r.covariance.rows(); ++i)
    covariance.push_back(report::json_numbers(Eigen::VectorXd(r.covariance.row(i))));
  return {{"asked", r.asked},
          {"parameters", rows},
          {"covariance", covariance},
          {"chi2_before", json_number(r.chi2_before)},
          {"chi2_after", json_number(r.chi2_after)},
          {"iterations", r.iterations},
          {"converged", r.converged},
          {"n", r.n},
          {"notes", r.notes}};
}

Json verdicts_json(const std::vector<ExplainedRow>& rows) {
  Json out = Json::object();
  for (const char* quantity : {"gray", "phase", "geometry"}) {
    const auto all = all_explained(rows, quantity);
    out[quantity] = all ? Json(*all ? "explained" : "not explained") : Json(nullptr);
  }
  return out;
}

Json cause_json(const CauseRow& r) {
  Json parameters = Json::array();
  for (const CauseParameter& p : r.parameters)
    parameters.push_back({{"name", p.name},
                          {"unit", p.unit},
                          {"twin", json_number(p.twin)},
                          {"estimate", json_number(p.estimate)},
                          {"estimate_sigma", json_number(p.sigma)}});
  return {{"group", r.group},
          {"cause", r.cause},
          {"alone", json_number(r.alone)},
          {"order", r.order},
          {"in_order", json_number(r.in_order)},
          {"parameters", parameters}};
}

template <class Rows, class ToJson>
Json list(const Rows& rows, ToJson to_json) {
  Json out = Json::array();
  for (const auto& row : rows) out.push_back(to_json(row));
  return out;
}

Json render_note_json(const RenderNote& n) {
  Json out = {{"camera", n.camera},
              {"sampler", n.sampler},
              {"precision", n.double_precision ? "fp64" : "fp32"},
              {"rays_per_pixel", json_number(n.rays_per_pixel)}};
  if (n.samples) out["samples"] = *n.samples;
  if (n.phase_error_rad) out["estimated_phase_error_rad"] = json_number(*n.phase_error_rad);
  if (n.gray_error) out["estimated_gray_error"] = json_number(*n.gray_error);
  return out;
}

Json head(const Twin& twin, const char* command_kind, const Provenance& provenance,
          const std::map<std::string, double>& timing_s) {
  Json out;
  out["schema"] = "fringetwin-result/1";
  out["kind"] = command_kind;
  out["twin"] = twin.name;
  Json inputs = Json::object();
  for (const auto& [file, digest] : sha256_of_files(provenance.input_files)) inputs[file] = digest;
  out["provenance"] = {{"argv", provenance.argv},
                       {"version", provenance.version},
                       {"inputs_sha256", inputs},
                       {"device", provenance.device.empty() ? Json(nullptr) : Json(provenance.device)},
                       {"seed", provenance.seed}};
  if (!provenance.rendered.empty())
    out["provenance"]["rendered"] = list(provenance.rendered, render_note_json);
  out["timing_s"] = Json::object();
  for (const auto& [stage, seconds] : timing_s) out["timing_s"][stage] = json_number(seconds);
  return out;
}

std::string dump(const Json& json) {
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

Json decode_json(const measure::Measurement& m) {
  Json out = Json::array();
  for (const auto& camera : m.cameras)
    for (const auto& d : camera.directions) {
      std::uint64_t valid = 0;
      for (double x : d.coordinate_px.data) valid += std::isfinite(x) ? 1 : 0;
      out.push_back({{"camera", camera.camera},
                     {"direction", axis_name(d.axis)},
                     {"n_valid", valid},
                     {"orders_checked", d.repair.n_checked},
                     {"orders_changed", d.repair.n_changed},
                     {"orders_left", d.repair.n_left}});
    }
  return out;
}

}  // namespace

std::string comparison_json(const Twin& twin, const Comparison& c, const Provenance& provenance,
                            const std::map<std::string, double>& timing_s) {
  Json out = head(twin, "comparison", provenance, timing_s);
  out["fits"] = list(c.fits, fit_row_json);
  out["indicators"] = list(c.indicators, indicator_json);
  out["gain"] = list(c.gain, gain_json);
  out["gray"] = list(c.gray, gray_json);
  out["gray_budget"] = list(c.gray_budget, budget_json);
  out["phase"] = list(c.phase, phase_json);
  out["phase_budget"] = list(c.phase_budget, phase_budget_json);
  out["noise"] = list(c.noise, noise_json);
  out["shift"] = list(c.shift, shift_json);
  if (c.refinement) out["refinement"] = refinement_json(*c.refinement);
  out["budget_verdict"] = verdicts_json(c.explained);
  out["explained"] = list(c.explained, explained_json);
  out["causes"] = {{"named", c.causes.named.empty() ? Json(nullptr) : Json(c.causes.named)},
                   {"chi2", json_number(c.causes.chi2)},
                   {"rest", json_number(c.causes.rest)},
                   {"n", c.causes.n},
                   {"tested", list(c.causes.rows, cause_json)}};
  out["limits"] = list(c.limits, [](const LimitRow& r) -> Json {
    return {
        {"name", r.name}, {"value", json_number(r.value)}, {"limit", json_number(r.limit)}, {"pass", r.pass}};
  });
  out["verdict"] = c.pass ? "pass" : "fail";
  out["warnings"] = c.warnings;
  return dump(out);
}

std::string measurement_json(const Twin& twin, const measure::Measurement& m, const Provenance& provenance,
                             const std::map<std::string, double>& timing_s) {
  Json out = head(twin, "measurement", provenance, timing_s);
  out["fits"] = list(m.fits, [](const ObjectFit& fit) -> Json {
    return {{"object", fit.object}, {"kind", fit.kind}, {"measured", fit_json(fit)}};
  });
  out["decode"] = decode_json(m);
  out["triangulation"] = {
      {"n_candidates", m.triangulation.n_candidates}, {"n_points", m.triangulation.n_points},
      {"n_no_match", m.triangulation.n_no_match},     {"n_ambiguous", m.triangulation.n_ambiguous},
      {"n_rejected", m.triangulation.n_rejected},     {"n_mixed", m.triangulation.n_mixed}};
  for (const char* key : {"gain", "gray", "phase", "limits"}) out[key] = Json::array();
  out["verdict"] = "pass";
  out["warnings"] = m.warnings;
  return dump(out);
}

}  // namespace fringetwin::compare
