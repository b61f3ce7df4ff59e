// SPDX-License-Identifier: Apache-2.0
#include "compare/result/result_json.hpp"

#include "compare/result/fit_json.hpp"
#include "compare/result/tables.hpp"

namespace fringetwin::compare {
namespace {

using report::Json;
using report::json_number;

Json render_note_json(const RenderNote& n) {
  Json out = {{"camera", n.camera},
              {"sampler", n.sampler},
              {"precision", n.double_precision ? "fp64" : "fp32"},
              {"rays_per_pixel", json_number(n.rays_per_pixel)}};
  if (n.samples) out["samples"] = *n.samples;
  if (n.phase_error_rad) out["estimated_phase_error_rad"] = json_number(*n.phase_error_rad);
  if (n.gray_error) out["estimated_gray_error"] = json_number(*n.gray_error);
  if (n.gray_inside_error) out["estimated_gray_error_inside"] = json_number(*n.gray_inside_error);
  return out;
}

Json head(const Twin& twin, const char* command_kind, const Provenance& provenance,
          const std::map<std::string, double>& timing_s) {
  Json out;
  out["schema"] = "fringetwin-result/1";
  out["kind"] = command_kind;
  out["twin"] = twin.name;
  out["provenance"] = {{"argv", provenance.argv},
                       {"version", provenance.version},
                       {"inputs_sha256", provenance.inputs_sha256},
                       {"device", provenance.device.empty() ? Json(nullptr) : Json(provenance.device)},
                       {"seed", provenance.seed}};
  if (!provenance.rendered.empty())
    for (const RenderNote& note : provenance.rendered)
      out["provenance"]["rendered"].push_back(render_note_json(note));
  out["timing_s"] = Json::object();
  for (const auto& [stage, seconds] : timing_s) out["timing_s"][stage] = json_number(seconds);
  return out;
}

std::string dump(const Json& json) {
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

/// Adds the tables that a comparison or a measurement has.
template <class Result>
void add_tables(const Result& result, std::function<Json(const Result&)> Table::*of, Json& out) {
  for (const Table& table : tables())
    if (table.*of)
      if (Json rows = (table.*of)(result); !rows.is_null()) out[table.key] = std::move(rows);
}

}  // namespace

std::string comparison_json(const Twin& twin, const Comparison& c, const Provenance& provenance,
                            const std::map<std::string, double>& timing_s) {
  Json out = head(twin, "comparison", provenance, timing_s);
  out["fits"] = Json::array();
  for (const FitRow& row : c.fits) out["fits"].push_back(fit_row_json(row));
  add_tables(c, &Table::of_comparison, out);
  out["verdict"] = c.pass ? "pass" : "fail";
  out["warnings"] = c.warnings;
  return dump(out);
}

Json measurement_tree(const Twin& twin, const measure::Measurement& m, const Provenance& provenance,
                      const std::map<std::string, double>& timing_s) {
  Json out = head(twin, "measurement", provenance, timing_s);
  out["fits"] = Json::array();
  for (const measure::ObjectFit& fit : m.fits)
    out["fits"].push_back({{"object", fit.object},
                           {"kind", fit.kind},
                           {"measured", fit_json(fit)},
                           {"method_bias", bias_json(fit)}});
  add_tables(m, &Table::of_measurement, out);
  out["verdict"] = "not judged";  // nothing was compared
  out["warnings"] = m.warnings;
  return out;
}

std::string measurement_json(const Twin& twin, const measure::Measurement& m, const Provenance& provenance,
                             const std::map<std::string, double>& timing_s) {
  return dump(measurement_tree(twin, m, provenance, timing_s));
}

}  // namespace fringetwin::compare
