// SPDX-License-Identifier: Apache-2.0

#include "report/json.hpp"
#include "tradeoff/pareto.hpp"
#include "tradeoff/tradeoff_json.hpp"

namespace fringetwin::tradeoff {
namespace {

using report::Json, report::json_number;

Json point_json(const ParetoPoint& p) {
  return {
      {"scheme", p.scheme.family},
      {"samples", p.scheme.is_adaptive() ? Json(nullptr) : Json(p.scheme.sampling.samples)},
      {"target_rad", p.scheme.is_adaptive() ? Json(p.scheme.sampling.phase_error_rad) : Json(nullptr)},
      {"precision", p.precision()},
      {"default", p.scheme.is_default},
      {"published", p.scheme.is_published},
      {"frame_ms", json_number(p.frame_ms)},
      {"frame_cpu_ms", json_number(p.frame_cpu_ms)},
      {"time_extrapolated_from_samples", p.extrapolated_from > 0 ? Json(p.extrapolated_from) : Json(nullptr)},
      {"rays", p.rays > 0 ? Json(p.rays) : Json(nullptr)},
      {"error", json_change(p.error)},
      {"fit_error_mm", json_number(p.fit_error_mm)},
      {"fit_rms_mm", json_number(p.fit_rms_mm)},
      {"fit_shift_mm", json_number(p.fit_shift_mm)},
      {"fit_reference", p.is_fit_reference},
      {"measure_s", json_number(p.measure_s)},
      {"chain_s", json_number(p.chain_s)},
      {"phase_front", p.on_phase_front},
      {"gray_front", p.on_gray_front},
      {"fit_front", p.on_fit_front}};
}

}  // namespace

std::string pareto_json(const Twin& twin, const ParetoResult& result, const ParetoOptions& options,
                        const compare::Provenance& provenance) {
  Json out =
      json_head("fringetwin-pareto/1", twin, provenance, result.device, result.subset, result.timing_s);
  out["quick"] = options.quick;
  out["reference"] = {{"gauss_interior", options.reference.gauss_interior},
                      {"gauss_facet", options.reference.gauss_facet},
                      {"gauss_edge", options.reference.gauss_edge},
                      {"edge_uncertainty_dn", json_number(result.reference_uncertainty_dn)}};
  out["n_cameras"] = twin.cameras.size();
  out["n_images"] = expand_sequence(twin.fringes).size();
  out["points"] = Json::array();
  for (const ParetoPoint& p : result.points) out["points"].push_back(point_json(p));
  out["warnings"] = result.warnings;
  return json_text(out);
}

}  // namespace fringetwin::tradeoff
