// SPDX-License-Identifier: Apache-2.0

#include "report/json.hpp"
#include "tradeoff/needs.hpp"
#include "tradeoff/tradeoff_json.hpp"

namespace fringetwin::tradeoff {
namespace {

using report::Json, report::json_number;

Json judged_json(const Change& c) {
  return {{"phase_rms_rad", json_number(c.phase_rad)},
          {"gray_rms_dn", json_number(c.gray_dn)},
          {"fit_mm", json_number(c.fit_mm)}};
}

Json fits_json(const std::vector<FitChange>& fits) {
  Json out = Json::array();
  for (const FitChange& f : fits)
    out.push_back({{"object", f.object},
                   {"change_mm", json_number(f.change_mm)},
                   {"n_with", f.n_with},
                   {"n_without", f.n_without}});
  return out;
}

Json row_json(const EffectRow& r) {
  Json out = {{"name", r.name},
              {"stage", r.stage == EffectStage::light ? "light" : "sensor"},
              {"state", r.on ? "on" : "off"},
              {"without", r.without},
              {"switch_on", r.switch_on}};
  if (!r.on) return out;
  out["change"] = json_change(r.change);
  out["fit_mm"] = json_number(r.fit_change_mm());
  out["fits"] = fits_json(r.fits);
  out["cost"] = json_number(r.cost);
  out["time_with_s"] = json_number(r.with.wall_s);
  out["time_without_s"] = json_number(r.without_time.wall_s);
  out["cpu_with_s"] = json_number(r.with.cpu_s);
  out["cpu_without_s"] = json_number(r.without_time.cpu_s);
  out["recommendation"] = r.leave_off ? "leave off" : "keep";
  return out;
}

}  // namespace

std::string needs_json(const Twin& twin, const NeedsResult& result, const NeedsOptions& options,
                       const compare::Provenance& provenance) {
  Json out = json_head("fringetwin-needs/1", twin, provenance, result.device, result.subset, result.timing_s);
  out["tolerance"] = {{"phase_rad", options.tolerance.phase_rad},
                      {"gray_dn", options.tolerance.gray_dn},
                      {"fit_mm", options.tolerance.fit_mm}};
  out["effects"] = Json::array();
  Json left_off = Json::array();
  for (const EffectRow& r : result.rows) {
    out["effects"].push_back(row_json(r));
    if (r.leave_off) left_off.push_back(r.name);
  }
  out["renderer_error"] = json_change(result.floor);
  out["renderer_error"]["reference_uncertainty_dn"] = json_number(result.reference_uncertainty_dn);
  out["smallest_model"] = {{"left_off", left_off},
                           {"change", judged_json(result.reduced)},
                           {"time_full_s", json_number(result.full_time.wall_s)},
                           {"time_s", json_number(result.reduced_time.wall_s)},
                           {"speed_up", json_number(result.reduced_cost)}};
  out["warnings"] = result.warnings;
  return json_text(out);
}

}  // namespace fringetwin::tradeoff
